#pragma once
/// @file
/// Code for several generations of processors in one binary.

/// Before a function: one copy for each generation of x86 processors, of which the loader takes the best. The address
/// sanitizer starts too late for that choice; GCC and clang name it each in their way.
#ifdef __has_feature
#define UDAR_HAS_FEATURE(name) __has_feature(name)
#else
#define UDAR_HAS_FEATURE(name) 0
#endif
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !UDAR_HAS_FEATURE(address_sanitizer)
#define UDAR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define UDAR_CLONES
#endif
