// Which parts are soft at the moment, and their law. See soft_part.h. RT: yes.
#include "core/contact/soft_part.h"

#include <limits>

#include "core/collision/primitive_gap.h"

namespace hapticd {
namespace {

/// A displacement this small is rest, m: far below the rounding of any contact.
constexpr double kAtRest = 1e-13;
/// Stiffer than this many kt a part does not move in a tick. Larger: displacements below rounding
/// enter the program.
constexpr double kImmovable = 1e12;

/// Spring and damper over a tick. Not finite when a damper has no time to yield.
struct PartLaw {
  double stiffness;       ///< K, N/m
  Vector3 equilibrium_G;  ///< v*, m
};

PartLaw part_law(const ToolParts& tool, double dt, const SoftPart& soft) noexcept {
  const ToolPart& part = tool.parts[static_cast<std::size_t>(soft.part)];
  if (!(part.damping > 0.0)) return {part.stiffness, Vector3::Zero()};
  if (!(dt > 0.0)) return {std::numeric_limits<double>::infinity(), soft.v_before_G};
  const double damped = part.damping / dt;
  // Not damped / (k + damped), which a tiny dt would make infinite by infinite.
  const double share = 1.0 / (1.0 + part.stiffness * dt / part.damping);
  return {part.stiffness + damped, share * soft.v_before_G};
}

bool is_soft(const ToolParts& tool, std::int32_t part) noexcept {
  const auto index = static_cast<std::size_t>(part);
  return index < tool.parts.size() && tool.parts[index].stiffness > 0.0;
}

}  // namespace

std::optional<ParameterFault> check_part(const ToolPart& part) noexcept {
  constexpr ParameterRange kStiffness{1.0, 1e9, true, "[1, 1e9]"};
  constexpr ParameterRange kDamping{0.0, 1e6, true, "[0, 1e6]"};
  if (part.stiffness != 0.0 && !contains(kStiffness, part.stiffness)) {
    return ParameterFault{"fingertip.stiffness_n_per_m", part.stiffness, kStiffness.text,
                          "Give the stiffness of the fingertip, or leave it out: rigid."};
  }
  if (!contains(kDamping, part.damping)) {
    return ParameterFault{"fingertip.damping_n_s_per_m", part.damping, kDamping.text,
                          "Give the damping of the fingertip; 0 is none."};
  }
  return std::nullopt;
}

void start_parts(const ToolParts& tool, SoftParts& soft) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < soft.size(); ++k) {
    if (!is_soft(tool, soft[k].part)) continue;
    if (kept != k) soft[kept] = soft[k];
    soft[kept].v_before_G = soft[kept].v_G;
    ++kept;
  }
  soft.truncate(kept);
}

void update_parts(const ToolParts& tool, const ContactSet& contacts, double near, SoftParts& soft,
                  int& refused) noexcept {
  std::array<double, kMaxSoftParts> gap;
  gap.fill(std::numeric_limits<double>::infinity());
  for (const Contact& contact : contacts.contacts) {
    int k = find_part(tool, soft, contact.key.tool_sphere);
    if (k < 0) {
      const std::int32_t part = tool.part_of(contact.key.tool_sphere);
      if (contact.gap > near || !is_soft(tool, part)) continue;
      if (!soft.push_back({part, Vector3::Zero(), Vector3::Zero()})) {
        ++refused;
        continue;
      }
      k = static_cast<int>(soft.size()) - 1;
    }
    double& nearest = gap[static_cast<std::size_t>(k)];
    nearest = std::min(nearest, contact.gap);
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < soft.size(); ++k) {
    if (gap[k] > 2.0 * near && soft[k].v_G.norm() <= kAtRest) continue;
    if (kept != k) soft[kept] = soft[k];
    ++kept;
  }
  soft.truncate(kept);
}

int model_parts(const ToolParts& tool, const Matrix3& R_WG, double kt, double dt,
                const SoftParts& soft, int unknowns, PartBlocks& models) noexcept {
  for (std::size_t k = 0; k < soft.size(); ++k) {
    PartBlock& model = models[k];
    const PartLaw law = part_law(tool, dt, soft[k]);
    model = PartBlock{};
    if (!(law.stiffness <= kImmovable * kt)) continue;
    model.unknown = unknowns;
    unknowns += 3;
    model.stiffness = law.stiffness;
    model.off_G = soft[k].v_G - law.equilibrium_G;
    model.pull_W = rotate(R_WG, -law.stiffness * model.off_G);
  }
  return unknowns;
}

Vector3 free_displacement(const ToolParts& tool, double dt, const SoftPart& soft) noexcept {
  const PartLaw law = part_law(tool, dt, soft);
  if (law.equilibrium_G.norm() <= kVanishing) return {0.0, 0.0, 0.0};
  return law.equilibrium_G;
}

}  // namespace hapticd
