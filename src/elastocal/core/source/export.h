/* What the library shows to the outside, one name for every level of instructions.
 *
 *     EXPORT int NAMED(core_version)(void);      core_version_baseline, core_version_v3
 *
 * LEVEL and LANES come from the command line of the compiler: hatch_build.py has the levels.
 */
#ifndef ELASTOCAL_EXPORT_H
#define ELASTOCAL_EXPORT_H

#ifndef LEVEL
#define LEVEL baseline
#endif

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#define NAMED(name) NAMED_AT(name, LEVEL)
#define NAMED_AT(name, level) NAMED_JOINED(name, level)
#define NAMED_JOINED(name, level) name##_##level

#endif
