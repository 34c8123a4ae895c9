// The force of the reference firmware, compiled with numbers of a few bits: the same source, with
// other types under the names that C gives them. To be included once in a program; its headers come
// first, since they mean the real types.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "tests/device/hid/narrow_number.h"

// The firmware is C, and types have its names: no warning about C++ is of interest from here on.
#pragma GCC system_header

#pragma push_macro("INT16_MAX")
#pragma push_macro("INT32_MAX")
#pragma push_macro("UINT32_MAX")
#undef INT16_MAX
#undef INT32_MAX
#undef UINT32_MAX
#define INT16_MAX static_cast<int>(Narrow<kBits, true>::kMost)
#define INT32_MAX static_cast<int>(Narrow<2 * kBits, true>::kMost)
#define UINT32_MAX static_cast<int>(Narrow<2 * kBits, false>::kMost)
#define int16_t ::hapticd::test::Narrow<::hapticd::test::kBits, true>
#define uint16_t ::hapticd::test::Narrow<::hapticd::test::kBits, false>
#define int32_t ::hapticd::test::Narrow<2 * ::hapticd::test::kBits, true>
#define int64_t ::hapticd::test::Narrow<4 * ::hapticd::test::kBits, true>
#define uint64_t ::hapticd::test::Narrow<4 * ::hapticd::test::kBits, false>
namespace hapticd::test::narrow {
#include "device/hid/reference_firmware/device_force.c"
}  // namespace hapticd::test::narrow
#undef int16_t
#undef uint16_t
#undef int32_t
#undef int64_t
#undef uint64_t
#undef INT16_MAX
#undef INT32_MAX
#undef UINT32_MAX
#pragma pop_macro("INT16_MAX")
#pragma pop_macro("INT32_MAX")
#pragma pop_macro("UINT32_MAX")
