// See soft_parts.h. RT: yes.
#include "core/contact/soft_parts.h"

#include <algorithm>
#include <limits>

#include "core/collision/primitive_gap.h"
#include "core/contact/clearance.h"

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

PartLaw part_law(const ContactInput& input, const SoftPart& soft) noexcept {
  const ToolPart& part = input.parts.parts[static_cast<std::size_t>(soft.part)];
  if (!(part.damping > 0.0)) return {part.stiffness, Vector3::Zero()};
  if (!(input.dt > 0.0)) return {std::numeric_limits<double>::infinity(), soft.v_before_G};
  const double damped = part.damping / input.dt;
  // Not damped / (k + damped), which a tiny dt would make infinite by infinite.
  const double share = 1.0 / (1.0 + part.stiffness * input.dt / part.damping);
  return {part.stiffness + damped, share * soft.v_before_G};
}

bool is_soft(const ToolParts& tool, std::int32_t part) noexcept {
  const auto index = static_cast<std::size_t>(part);
  return index < tool.parts.size() && tool.parts[index].stiffness > 0.0;
}

}  // namespace

void SoftParts::begin(const ContactInput& input, TouchedParts& soft) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < soft.size(); ++k) {
    if (!is_soft(input.parts, soft[k].part)) continue;
    if (kept != k) soft[kept] = soft[k];
    soft[kept].v_before_G = soft[kept].v_G;
    ++kept;
  }
  soft.truncate(kept);
}

bool SoftParts::touch(const ContactInput& input, const ContactSet& contacts, TouchedParts& soft,
                      int& refused) noexcept {
  const double near = kTouchSkins * skin_of(input.options);
  bool changed = false;
  std::array<double, kMaxSoftParts> gap;
  gap.fill(std::numeric_limits<double>::infinity());
  for (const Contact& contact : contacts.contacts) {
    int k = find_part(input.parts, soft, contact.key.tool_sphere);
    if (k < 0) {
      const std::int32_t part = input.parts.part_of(contact.key.tool_sphere);
      if (contact.gap > near || !is_soft(input.parts, part)) continue;
      if (!soft.push_back({part, Vector3::Zero(), Vector3::Zero()})) {
        ++refused;
        continue;
      }
      changed = true;
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
  changed = changed || kept != soft.size();
  soft.truncate(kept);
  return changed;
}

Vector3 SoftParts::rest_of(const ContactInput& input, const SoftPart& soft) noexcept {
  const PartLaw law = part_law(input, soft);
  if (law.equilibrium_G.norm() <= kVanishing) return {0.0, 0.0, 0.0};
  return law.equilibrium_G;
}

double SoftParts::free_travel(const Configuration& at) noexcept {
  double travel = 0.0;
  for (const SoftPart& soft : at.state.parts) {
    travel = std::max(travel, (rest_of(at.input, soft) - soft.v_G).norm());
  }
  return travel;
}

void SoftParts::relax(const ContactInput& input, TouchedParts& parts) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    SoftPart soft = parts[k];
    soft.v_G = rest_of(input, soft);
    if (soft.v_G.squaredNorm() > 0.0) parts[kept++] = soft;
  }
  parts.truncate(kept);
}

int SoftParts::build(const Configuration& at, const ContactSet& /*contacts*/,
                     int unknowns) noexcept {
  const TouchedParts& soft = at.state.parts;
  if (soft.empty()) return unknowns;
  const Matrix3 R_WG = rotation_matrix(at.state.X_WG.q);
  for (std::size_t k = 0; k < soft.size(); ++k) {
    PartBlock& block = blocks_[k];
    const PartLaw law = part_law(at.input, soft[k]);
    block = PartBlock{};
    if (!(law.stiffness <= kImmovable * at.input.stiffness.kt)) continue;
    block.unknown = unknowns;
    unknowns += 3;
    block.stiffness = law.stiffness;
    block.off_G = soft[k].v_G - law.equilibrium_G;
    block.pull_W = rotate(R_WG, -law.stiffness * block.off_G);
  }
  return unknowns;
}

void SoftParts::measure(const ContactState& state, UnknownScale& scale) const noexcept {
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    if (blocks_[k].unknown < 0) continue;
    const auto first = static_cast<std::size_t>(blocks_[k].unknown);
    for (std::size_t i = 0; i < 3; ++i) {
      scale.inverse_root[first + i] = 1.0 / std::sqrt(blocks_[k].stiffness);
      scale.downhill[first + i] = blocks_[k].pull_W[static_cast<Eigen::Index>(i)];
    }
  }
}

void SoftParts::read_step(const Configuration& at, const Unknowns& y,
                          ConfigurationStep& step) const noexcept {
  const TouchedParts& soft = at.state.parts;
  if (soft.empty()) return;
  const Matrix3 R_GW = rotation_matrix(at.state.X_WG.q).transpose();
  for (std::size_t k = 0; k < soft.size(); ++k) {
    Vector3 dv_W = Vector3::Zero();
    if (const int unknown = blocks_[k].unknown; unknown >= 0) {
      const auto v = static_cast<std::size_t>(unknown);
      dv_W = Vector3(y[v], y[v + 1], y[v + 2]);
    }
    step.parts[k] = {dv_W, rotate(R_GW, dv_W)};
  }
}

double SoftParts::travel(const Configuration& at, const ConfigurationStep& step) noexcept {
  double greatest = 0.0;
  for (std::size_t k = 0; k < at.state.parts.size(); ++k) {
    greatest = std::max(greatest, step.parts[k].dv_G.norm());
  }
  return greatest;
}

double SoftParts::energy_gain(const Configuration& at,
                              const ConfigurationStep& step) const noexcept {
  double gain = 0.0;
  for (std::size_t k = 0; k < at.state.parts.size(); ++k) {
    const PartMotion& motion = step.parts[k];
    gain += blocks_[k].stiffness * motion.dv_G.dot(blocks_[k].off_G + 0.5 * motion.dv_G);
  }
  return gain;
}

void SoftParts::add_stored_energy(const Configuration& at, double& energy) const noexcept {
  for (std::size_t k = 0; k < at.state.parts.size(); ++k) {
    energy += 0.5 * blocks_[k].stiffness * blocks_[k].off_G.squaredNorm();
  }
}

void SoftParts::commit(const ContactInput& /*input*/, const ConfigurationStep& step,
                       ContactState& state) noexcept {
  for (std::size_t k = 0; k < state.parts.size(); ++k) state.parts[k].v_G += step.parts[k].dv_G;
}

}  // namespace hapticd
