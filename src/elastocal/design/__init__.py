"""Optimal design of experiments: criteria, continuous designs, certificates, exact designs."""
