/* What this machine can do. Compiled for any machine, as it is asked before anything else. */
#include "export.h"

EXPORT int core_has_v3(void);

/* Whether there are the instructions with which level v3 is compiled, and the system keeps
 * their registers. */
EXPORT int core_has_v3(void) {
#ifdef __x86_64__
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           __builtin_cpu_supports("bmi2");
#else
    return 0;
#endif
}
