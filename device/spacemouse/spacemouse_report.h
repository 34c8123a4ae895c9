// Input reports of 3Dconnexion's SpaceMouse family: six axes of deflection, not of position, and
// buttons. Sources: spacenavd src/dev.c (which devices), PySpaceMouse and FreePIE (layouts).
// Reports are known by ID and length: 1 and 2 with three axes each, 1 with all six (newer devices),
// 3 buttons; battery and the rest are of no consequence. Raw axes: x right, y toward the user, z
// down, rotations right-handed about them. Units: raw, about 350 at full deflection. RT: yes.
#pragma once

#include <cstdint>
#include <span>

#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd::spacemouse {

/// Beyond any deflection the cap can have, raw units; what is more is cut to this. Less: full speed
/// is lost; more: a damaged report moves the tool farther in the 8 ms until the next one.
inline constexpr int kMaxReading = 512;

/// True for the numbers of devices with a six-axis cap and reports as here, and of receivers that
/// such a device may be behind; false for mice and keyboards of the same maker.
[[nodiscard]] bool is_spacemouse(std::uint16_t vendor_id, std::uint16_t product_id) noexcept;

/// True for the numbers of receivers: they show the mice and keyboards behind them too, and only
/// the descriptor tells which is which.
[[nodiscard]] bool is_receiver(std::uint16_t vendor_id, std::uint16_t product_id) noexcept;

/// True when a report descriptor has a multi-axis controller (usage page 1, usage 8) as a device of
/// its own: a cap with six axes, by whatever cable or radio. Any bytes; O(bytes).
[[nodiscard]] bool has_six_axes(std::span<const std::uint8_t> descriptor) noexcept;

/// The content of a report.
enum class Content : std::uint8_t {
  kTranslation,  ///< `translation` alone
  kRotation,     ///< `rotation` alone
  kMotion,       ///< both
  kButtons,      ///< `buttons`
  kNothing,      ///< battery or another report of no consequence
  kMalformed,    ///< too short for its ID
};

/// One report. What its content does not name is zero.
struct Report {
  Content content = Content::kMalformed;
  Array3 translation{};       ///< along the raw axes
  Array3 rotation{};          ///< about the raw axes
  std::uint32_t buttons = 0;  ///< bit i = the device's button i; of the first 32
};

/// Reads one report, ID first. Any bytes.
[[nodiscard]] HD_REALTIME Report decode(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace hapticd::spacemouse
