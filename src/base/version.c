/* version.c - what this build is; the makefile defines the texts when it compiles this file. */
#include "base/base.h"

#ifndef MPM_GIT
#define MPM_GIT "unknown"
#endif
#ifndef MPM_COMPILER
#define MPM_COMPILER "unknown"
#endif
#ifndef MPM_CFLAGS
#define MPM_CFLAGS "unknown"
#endif

const char MPMVersionGit[] = MPM_GIT, MPMVersionCompiler[] = MPM_COMPILER, MPMVersionFlags[] = MPM_CFLAGS;
