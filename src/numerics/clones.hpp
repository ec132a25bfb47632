#pragma once
/// @file
/// Code for several generations of processors in one binary.

/// Before a function: one copy for each generation of x86 processors, of which the loader takes the best. The address
/// sanitizer starts too late for that choice.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
#define UDAR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define UDAR_CLONES
#endif
