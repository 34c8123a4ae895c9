// What a device of HID profile v1 reads of the reports sent to it, from the tables of PROFILE.md;
// the way back of encode() of profile_codec.h.
#pragma once

#include "device/hid/profile_codec.h"
#include "device/hid/report_bytes.h"

namespace hapticd::test {

inline void take_command(hid::FieldReader& reader, hid::CommandReport& command) {
  reader.take(command.flags);
  reader.take(command.seq);
  reader.take(command.force_un);
  reader.take(command.torque_unm);
  reader.take(command.grip_mn);
  reader.take(command.ref_seq);
}

inline hid::Decoded check_sent(std::span<const std::uint8_t> bytes, std::size_t length,
                               std::uint8_t id) {
  if (bytes.size() != length) return hid::Decoded::kWrongLength;
  return bytes[0] == id ? hid::Decoded::kOk : hid::Decoded::kWrongId;
}

/// Output 0x02. `command` is untouched unless kOk.
inline hid::Decoded decode_command(std::span<const std::uint8_t> bytes,
                                   hid::CommandReport& command) {
  const hid::Decoded found = check_sent(bytes, hid::kCommandBytes, hid::kCommandId);
  if (found != hid::Decoded::kOk) return found;
  hid::FieldReader reader(bytes.subspan(1));
  take_command(reader, command);
  return found;
}

/// Output 0x03. `affine` is untouched unless kOk; kOutOfRange: a stiffness along an axis is
/// negative.
inline hid::Decoded decode_affine(std::span<const std::uint8_t> bytes, hid::AffineReport& affine) {
  const hid::Decoded found = check_sent(bytes, hid::kAffineBytes, hid::kAffineId);
  if (found != hid::Decoded::kOk) return found;
  hid::AffineReport next;
  hid::FieldReader reader(bytes.subspan(1));
  take_command(reader, next.base);
  reader.take(next.k_npm);
  reader.take(next.b_mnspm);
  reader.take(next.kr_mnmprad);
  reader.take(next.br_10unmsprad);
  for (std::size_t i = 0; i < 3; ++i) {
    if (next.k_npm[i] < 0) return hid::Decoded::kOutOfRange;
  }
  affine = next;
  return found;
}

}  // namespace hapticd::test
