// See spacemouse_report.h.
#include "device/spacemouse/spacemouse_report.h"

#include <algorithm>
#include <array>
#include <optional>

#include "device/report_io/descriptor_reader.h"

namespace hapticd::spacemouse {
namespace {

constexpr std::uint16_t kLogitech = 0x046D;
constexpr std::uint16_t k3Dconnexion = 0x256F;
/// Of Logitech's number: SpaceMouse Plus XT, CadMan, SpaceMouse Classic, SpaceBall 5000,
/// SpaceTraveler, SpacePilot, SpaceNavigator, SpaceExplorer, SpaceNavigator for Notebooks,
/// SpacePilot Pro, SpaceMouse Pro, NuLOOQ.
constexpr std::array<std::uint16_t, 12> kOfLogitech{0xC603, 0xC605, 0xC606, 0xC621, 0xC623, 0xC625,
                                                    0xC626, 0xC627, 0xC628, 0xC629, 0xC62B, 0xC640};
/// SpaceMouse Wireless, Pro Wireless, Enterprise, Compact, Module, by cable and through a receiver
/// of their own.
constexpr std::array<std::uint16_t, 9> kOf3Dconnexion{0xC62E, 0xC62F, 0xC631, 0xC632, 0xC633,
                                                      0xC635, 0xC636, 0xC638, 0xC63A};
/// Receivers for several devices of 3Dconnexion, and numbers that are now a cap and now a mouse.
constexpr std::array<std::uint16_t, 3> kReceivers{0xC641, 0xC652, 0xC658};

constexpr std::uint8_t kTranslationId = 1;
constexpr std::uint8_t kRotationId = 2;
constexpr std::uint8_t kButtonsId = 3;
constexpr std::size_t kThreeAxes = 7;
constexpr std::size_t kSixAxes = 13;

/// Looks for a multi-axis controller among the application collections.
struct Reader {
  DescriptorFlaw take(const DescriptorItem& item) noexcept {
    if (item.kind == ItemKind::kUsage && !usage) usage = named_usage(item);
    if (item.kind == ItemKind::kEndCollection && depth-- == 0) return DescriptorFlaw::kUnbalanced;
    if (item.kind == ItemKind::kCollection) {
      constexpr std::uint32_t kApplication = 1;
      constexpr std::uint32_t kMultiAxisController = usage_of(0x01, 0x08);
      ++depth;
      found = found || (item.value == kApplication && usage &&
                        globals->resolve(*usage) == kMultiAxisController);
    }
    if (is_main(item.kind)) usage.reset();
    return globals.take(item);
  }
  [[nodiscard]] bool is_closed() const noexcept { return depth == 0; }

  GlobalItems globals;
  std::optional<NamedUsage> usage;
  std::size_t depth = 0;
  bool found = false;
};

/// Three signed 16-bit numbers, low byte first.
Array3 three(std::span<const std::uint8_t> bytes) noexcept {
  Array3 axes{};
  for (std::size_t i = 0; i < 3; ++i) {
    const unsigned both = bytes[2 * i] | unsigned{bytes[2 * i + 1]} << 8U;
    const int value = both < 0x8000U ? static_cast<int>(both) : static_cast<int>(both) - 0x10000;
    axes[i] = std::clamp(value, -kMaxReading, kMaxReading);
  }
  return axes;
}

}  // namespace

bool is_spacemouse(std::uint16_t vendor_id, std::uint16_t product_id) noexcept {
  const auto in = [product_id](const auto& list) {
    return std::find(list.begin(), list.end(), product_id) != list.end();
  };
  return (vendor_id == kLogitech && in(kOfLogitech)) ||
         (vendor_id == k3Dconnexion && in(kOf3Dconnexion)) || is_receiver(vendor_id, product_id);
}

bool is_receiver(std::uint16_t vendor_id, std::uint16_t product_id) noexcept {
  return vendor_id == k3Dconnexion &&
         std::find(kReceivers.begin(), kReceivers.end(), product_id) != kReceivers.end();
}

bool has_six_axes(std::span<const std::uint8_t> descriptor) noexcept {
  Reader reader;
  return read_items(descriptor, reader) == DescriptorFlaw::kNone && reader.found;
}

Report decode(std::span<const std::uint8_t> bytes) noexcept {
  Report report;
  if (bytes.empty()) return report;
  const std::uint8_t id = bytes[0];
  if (id == kTranslationId || id == kRotationId) {
    if (bytes.size() < kThreeAxes) return report;
    const bool all = id == kTranslationId && bytes.size() >= kSixAxes;
    (id == kRotationId ? report.rotation : report.translation) = three(bytes.subspan(1));
    if (all) report.rotation = three(bytes.subspan(kThreeAxes));
    report.content = all                 ? Content::kMotion
                     : id == kRotationId ? Content::kRotation
                                         : Content::kTranslation;
    return report;
  }
  if (id != kButtonsId) {
    report.content = Content::kNothing;
    return report;
  }
  if (bytes.size() < 2) return report;
  const std::size_t count = std::min(bytes.size() - 1, sizeof report.buttons);
  for (std::size_t i = 0; i < count; ++i) {
    report.buttons |= std::uint32_t{bytes[1 + i]} << (8 * i);
  }
  report.content = Content::kButtons;
  return report;
}

}  // namespace hapticd::spacemouse
