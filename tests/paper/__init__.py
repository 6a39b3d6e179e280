"""The paper's tables and the best known answers to its two planning problems."""
