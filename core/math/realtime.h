// Marks functions of the realtime path: no heap, lock, throw, log, unlisted system call or
// unbounded loop. Compilers that know the attribute (clang >= 20) check it at compile time and, in
// the rtsan preset, at run time. Costs nothing elsewhere.
#pragma once

#if defined(__clang__) && __clang_major__ >= 20
// This spelling, unlike [[clang::nonblocking]], may stand in front of a declaration.
#define HD_REALTIME __attribute__((nonblocking))
#else
#define HD_REALTIME
#endif
