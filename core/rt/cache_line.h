// The unit in which CPU cores hand memory to each other. Data written by different threads stands
// on different lines, so that neither slows the other down. RT: constants only.
#pragma once

#include <cstddef>

namespace hapticd {

/// Bytes of a cache line on x86-64. Smaller: threads disturb each other; larger: memory wasted. The
/// standard's own constant (hardware_destructive_interference_size) is unknown to clang 14 and
/// varies with -mtune in gcc.
inline constexpr std::size_t kCacheLineBytes = 64;

}  // namespace hapticd
