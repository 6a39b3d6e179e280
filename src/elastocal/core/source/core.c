/* The compiled core, once for every level of instructions. */
#include "export.h"

EXPORT int NAMED(core_version)(void);

/* Raised with every change of what is exported; `VERSION` in library.py is the same number. */
EXPORT int NAMED(core_version)(void) { return 1; }
