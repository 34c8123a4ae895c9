// States and events as the structs of hapticd_client.h. Pure. Not RT.
#pragma once

#include <hapticd/v1/state.pb.h>
#include <hapticd/v1/stream.pb.h>
#include <hapticd_client.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace hapticd::client {

/// The State, as far as there is room; size as of this version.
[[nodiscard]] hapticd_state c_state(const v1::State& state);
/// Whether the Item is an event that C callers are told of.
[[nodiscard]] bool is_c_event(const v1::Item& item);
/// That event, without own_ns and dropped; size as of this version.
[[nodiscard]] hapticd_event c_event(const v1::Item& item);

/// How much of a text in UTF-8 goes into `most` bytes with no character cut in two.
[[nodiscard]] std::size_t whole_characters(std::string_view text, std::size_t most);

/// A caller's struct that is larger was not meant: its size is not set.
inline constexpr std::uint32_t kMostStruct_bytes = 65536;

/// Whether the caller's struct can take what the first version has. Reads its size alone.
template <typename Struct>
bool is_large_enough(const Struct* target) {
  return target != nullptr && target->size >= sizeof(Struct) && target->size <= kMostStruct_bytes;
}

/// Copies into the caller's struct, which is_large_enough(); members of a newer version become 0.
template <typename Struct>
void hand_over(Struct made, Struct* target) {
  const std::uint32_t size = target->size;
  made.size = size;
  std::memcpy(target, &made, sizeof made);
  std::memset(reinterpret_cast<char*>(target) + sizeof made, 0, size - sizeof made);
}

}  // namespace hapticd::client
