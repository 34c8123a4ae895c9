// See encode_state.h.
#include "server/encoding/encode_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

namespace hapticd {
namespace {

/// Residuals up to these are told as 0, N and m.
constexpr double kResidualForce = 1e-9;
constexpr double kResidualGap = 1e-12;

/// Where along a cable its last knot is certainly passed: its shares round.
constexpr double kLastKnot = 1.0 - 1e-9;

bool wants(const StateRequest& request, v1::Section section) {
  return (request.sections >> static_cast<unsigned>(section) & 1U) != 0;
}

/// `value` in units of 1 / `scale`, to nearest, ties to even, kept within Integer.
template <typename Integer>
Integer rounded(double value, double scale) {
  constexpr auto kMin = static_cast<double>(std::numeric_limits<Integer>::min());
  constexpr auto kMax = static_cast<double>(std::numeric_limits<Integer>::max());
  const double scaled = std::nearbyint(value * scale);
  if (std::isnan(scaled)) return 0;
  if (scaled <= kMin) return std::numeric_limits<Integer>::min();
  if (scaled >= kMax) return std::numeric_limits<Integer>::max();
  return static_cast<Integer>(scaled);
}

template <typename Numbers>
void add_doubles(const Array3& numbers, Numbers* out) {
  for (const double number : numbers) out->Add(number);
}

template <std::size_t Size>
void add_floats(const std::array<double, Size>& numbers,
                google::protobuf::RepeatedField<float>* out) {
  for (const double number : numbers) out->Add(static_cast<float>(number));
}

void add_wrench(const PlainWrench& wrench, google::protobuf::RepeatedField<float>* out) {
  add_floats(wrench.f, out);
  add_floats(wrench.t, out);
}

bool equal(const PlainWrench& a, const PlainWrench& b) { return a.f == b.f && a.t == b.t; }

void encode_tool(const ToolTick& tool, v1::ToolState& out) {
  out.set_tool_id(tool.tool_id);
  add_doubles(tool.X_WH.p, out.mutable_p_wh_m());
  add_floats(tool.X_WH.q, out.mutable_q_wh());
  add_doubles(tool.X_WG.p, out.mutable_p_wg_m());
  add_floats(tool.X_WG.q, out.mutable_q_wg());
  add_wrench(tool.F_written_H_W, out.mutable_wrench_h_w());
  if (!equal(tool.F_written_H_W, tool.F_computed_H_W)) {
    add_wrench(tool.F_computed_H_W, out.mutable_wrench_unlimited_h_w());
  }
  out.set_minimum_gap_m(static_cast<float>(std::clamp(tool.contact.minimum_gap, -1.0, 1.0)));
  // Rounding of the solver is not worth its bytes.
  if (tool.contact.residual_force > kResidualForce) {
    out.set_residual_n(static_cast<float>(tool.contact.residual_force));
  }
  if (tool.contact.residual_gap > kResidualGap) {
    out.set_residual_m(static_cast<float>(tool.contact.residual_gap));
  }
  for (int bit = 0; bit < 16; ++bit) {
    if ((tool.flags >> bit & 1) != 0) out.add_flags(static_cast<v1::ToolFlag>(bit + 1));
  }
}

void encode_device(const ToolTick& tool, v1::DeviceState& out) {
  const DeviceSample& device = tool.sample;
  out.set_tool_id(tool.tool_id);
  add_doubles(device.p_DH, out.mutable_p_dh_m());
  add_floats(device.q_DH, out.mutable_q_dh());
  out.set_buttons(device.buttons);
  if (!std::isnan(device.grip_m)) out.set_grip_m(device.grip_m);
  if (!std::isnan(device.temperature_deg_c)) out.set_temperature_deg_c(device.temperature_deg_c);
  for (int bit = 0; bit < 16; ++bit) {
    if ((device.flags >> bit & 1) != 0) out.add_flags(static_cast<v1::DeviceFlag>(bit + 1));
  }
}

v1::StringPhase phase_of(const StringTick& string) {
  if (!string.touched) return v1::STRING_PHASE_RINGING;
  if (string.armed) return v1::STRING_PHASE_PRESSED;
  return string.phase >= StringPhase::kFundamental ? v1::STRING_PHASE_DAMPED
                                                   : v1::STRING_PHASE_TOUCHED;
}

double length_of(const Array3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// What a tick says of one string of the scene: of a cable in several pieces the row of the one
/// that moves most, null when all are asleep; and its vertices from A to B.
struct ToldString {
  const StringTick* row = nullptr;
  std::span<const StringBendTick> bends;
};

/// The vertex that counts as the string's own: that of who plays it, else the one furthest off.
const StringBendTick* own_bend(const ToldString& told) {
  const StringBendTick* own = nullptr;
  for (const StringBendTick& bend : told.bends) {
    const bool plays =
        told.row != nullptr && told.row->string == bend.string && told.row->tool == bend.tool;
    if (plays) return &bend;
    if (own == nullptr || length_of(bend.deflection_W) > length_of(own->deflection_W)) own = &bend;
  }
  return own;
}

void add_vertex(double lambda, const Array3& deflection_W, v1::StringState& out) {
  out.add_further_lambda(static_cast<float>(lambda));
  add_floats(deflection_W, out.mutable_further_deflection_w_m());
}

/// All vertices but `own`; of a cable the knots too between which a piece is bent.
void add_further(const ToldString& told, const StringBendTick* own, const SceneIndex& index,
                 v1::StringState& out) {
  std::int32_t last = -1;
  for (const StringBendTick& bend : told.bends) {
    const PieceOwner& piece = index.pieces[static_cast<std::size_t>(bend.string)];
    const bool next = bend.string == last + 1;
    if (bend.string != last && !next && piece.lambda_begin > 0.0) {
      add_vertex(piece.lambda_begin, {}, out);
    }
    if (&bend != own) add_vertex(whole_lambda(piece, bend.lambda), bend.deflection_W, out);
    const bool ends =
        &bend + 1 == told.bends.data() + told.bends.size() || (&bend + 1)->string != bend.string;
    if (ends && piece.lambda_begin + piece.lambda_share < kLastKnot) {
      add_vertex(piece.lambda_begin + piece.lambda_share, {}, out);
    }
    last = bend.string;
  }
}

void encode_string(const ToldString& told, const SceneIndex& index, v1::StringState& out) {
  const StringBendTick* const own = own_bend(told);
  if (told.row == nullptr && own == nullptr) return;
  const std::int32_t capsule = told.row != nullptr ? told.row->string : own->string;
  const PieceOwner& piece = index.pieces[static_cast<std::size_t>(capsule)];
  out.set_string_index(piece.index);
  out.set_phase(told.row != nullptr ? phase_of(*told.row) : v1::STRING_PHASE_TOUCHED);
  add_floats(own != nullptr ? own->deflection_W : told.row->deflection_W,
             out.mutable_deflection_w_m());
  const double lambda =
      own == nullptr
          ? whole_lambda(piece, told.row->lambda)
          : whole_lambda(index.pieces[static_cast<std::size_t>(own->string)], own->lambda);
  out.set_lambda(static_cast<float>(lambda));
  const double growth =
      told.row != nullptr ? told.row->radius_growth : length_of(own->deflection_W);
  out.set_radius_m(static_cast<float>(piece.radius + growth));
  add_further(told, own, index, out);
}

/// One row per string.
void encode_strings(const Tick& tick, const SceneIndex& index, v1::State& state) {
  const auto owner = [&](std::int32_t capsule) {
    return index.pieces[static_cast<std::size_t>(capsule)].index;
  };
  const auto* row = tick.strings.begin();
  const auto* bend = tick.string_bends.begin();
  while (row != tick.strings.end() || bend != tick.string_bends.end()) {
    const std::uint32_t string = bend == tick.string_bends.end() ? owner(row->string)
                                 : row == tick.strings.end()
                                     ? owner(bend->string)
                                     : std::min(owner(row->string), owner(bend->string));
    ToldString told;
    for (; row != tick.strings.end() && owner(row->string) == string; ++row) {
      if (told.row == nullptr || row->radius_growth > told.row->radius_growth) told.row = row;
    }
    const auto* const first = bend;
    while (bend != tick.string_bends.end() && owner(bend->string) == string) ++bend;
    told.bends = {first, bend};
    encode_string(told, index, *state.add_strings());
  }
}

/// The object of a patch.
struct ObjectKey {
  v1::ContactPatch::ObjectCase kind = v1::ContactPatch::OBJECT_NOT_SET;
  std::uint32_t index = 0;
};

ObjectKey object_of(const ContactKey& key, const SceneIndex& index) {
  if (is_body(key)) {
    return {v1::ContactPatch::kBodyIndex, static_cast<std::uint32_t>(key.obstacle)};
  }
  const PieceOwner& piece = index.pieces[static_cast<std::size_t>(key.obstacle)];
  return {piece.is_string ? v1::ContactPatch::kStringIndex : v1::ContactPatch::kLineIndex,
          piece.index};
}

std::uint32_t index_in(const v1::ContactPatch& patch) {
  switch (patch.object_case()) {
    case v1::ContactPatch::kStringIndex:
      return patch.string_index();
    case v1::ContactPatch::kBodyIndex:
      return patch.body_index();
    case v1::ContactPatch::kLineIndex:
      return patch.line_index();
    case v1::ContactPatch::OBJECT_NOT_SET:
      break;
  }
  return 0;
}

v1::ContactPatch& patch_for(const ObjectKey& object, std::uint32_t tool_id, v1::State& state) {
  for (v1::ContactPatch& patch : *state.mutable_contacts()) {
    if (patch.tool_id() == tool_id && patch.object_case() == object.kind &&
        index_in(patch) == object.index) {
      return patch;
    }
  }
  v1::ContactPatch& patch = *state.add_contacts();
  patch.set_tool_id(tool_id);
  switch (object.kind) {
    case v1::ContactPatch::kStringIndex:
      patch.set_string_index(object.index);
      break;
    case v1::ContactPatch::kBodyIndex:
      patch.set_body_index(object.index);
      break;
    default:
      patch.set_line_index(object.index);
      break;
  }
  for (int axis = 0; axis < 3; ++axis) patch.add_force_w_n(0.0F);
  return patch;
}

void add_force(const Array3& F_W, v1::ContactPatch& patch) {
  for (int axis = 0; axis < 3; ++axis) {
    patch.set_force_w_n(
        axis, patch.force_w_n(axis) + static_cast<float>(F_W[static_cast<std::size_t>(axis)]));
  }
}

void encode_contact(const ContactTick& contact, v1::ContactPatch& patch) {
  patch.add_tool_sphere(contact.key.tool_sphere);
  for (const double p : contact.p_WC) patch.add_p_wc_um(rounded<std::int64_t>(p, 1e6));
  for (const double n : contact.nhat_OG_W) patch.add_nhat_og_w_e4(rounded<std::int32_t>(n, 1e4));
  patch.add_gap_nanometres(rounded<std::int32_t>(contact.gap, 1e9));
  patch.add_force_mn(rounded<std::uint32_t>(contact.force, 1e3));
}

/// Whether each contact is among the `most` with the smallest gaps.
std::array<bool, kMaxReportedContacts> deepest_of(const Tick& tick, std::uint32_t most) {
  std::array<bool, kMaxReportedContacts> chosen{};
  const std::size_t count = tick.contacts.size();
  if (most >= count) {
    std::fill_n(chosen.begin(), count, true);
    return chosen;
  }
  // Not set to anything: 2 kB, of which few are used.
  std::array<std::size_t, kMaxReportedContacts> order;
  std::iota(order.begin(), order.begin() + count, 0);
  // Of equal gaps the first: std::stable_sort would ask the heap for room.
  std::sort(order.begin(), order.begin() + count, [&](std::size_t a, std::size_t b) {
    const double gap_a = tick.contacts[a].gap;
    const double gap_b = tick.contacts[b].gap;
    return gap_a != gap_b ? gap_a < gap_b : a < b;
  });
  for (std::size_t k = 0; k < most; ++k) chosen[order[k]] = true;
  return chosen;
}

void encode_contacts(const Tick& tick, const SceneIndex& index, std::uint32_t most,
                     v1::State& state) {
  const auto listed = deepest_of(tick, most);
  std::size_t next = 0;
  for (const ToolTick& tool : tick.tools) {
    const std::size_t end = next + static_cast<std::size_t>(tool.contacts);
    for (; next < end; ++next) {
      const ContactTick& contact = tick.contacts[next];
      const ObjectKey object = object_of(contact.key, index);
      v1::ContactPatch& patch = patch_for(object, tool.tool_id, state);
      if (object.kind != v1::ContactPatch::kStringIndex) {
        const Vector3 F_W = contact.force * to_vector(contact.nhat_OG_W);
        add_force(to_array(F_W), patch);
      }
      if (listed[next]) encode_contact(contact, patch);
    }
  }
  for (const StringForceTick& string : tick.string_forces) {
    const PieceOwner& piece = index.pieces[static_cast<std::size_t>(string.string)];
    const std::uint32_t tool_id = tick.tools[static_cast<std::size_t>(string.tool)].tool_id;
    add_force(string.F_W, patch_for({v1::ContactPatch::kStringIndex, piece.index}, tool_id, state));
  }
  const auto total = static_cast<std::uint32_t>(tick.contacts_total);
  if (std::min<std::size_t>(most, tick.contacts.size()) < total) {
    state.set_contacts_total(total);
  }
}

void encode_energy(const Tick& tick, v1::Energy& out) {
  out.set_strings_j(static_cast<float>(tick.string_energy));
  out.set_tanks_j(static_cast<float>(tick.tank_energy));
  for (const ToolTick& tool : tick.tools) {
    v1::ToolEnergy& energy = *out.add_tools();
    energy.set_tool_id(tool.tool_id);
    energy.set_port_j(static_cast<float>(tool.port.given));
    energy.set_removed_j(static_cast<float>(tool.port.removed));
  }
}

void encode_quality(const Tick& tick, v1::QualityState& out) {
  out.set_level(tick.budget.level);
  out.set_automatic(tick.budget.automatic);
  out.set_reason(v1::QUALITY_REASON_CHOSEN);
  out.set_substeps(tick.work.sub_steps);
  out.set_sphere_tests(tick.work.sphere_tests);
  out.set_qp_iterations(tick.work.qp_iterations);
  out.set_work(tick.work.work);
  out.set_work_budget(tick.budget.work);
  out.set_cut_short(tick.work.cut_short);
}

void encode_stages(const StageTimes& times, v1::Timing& out) {
  const auto add = [&](v1::Stage stage, std::uint32_t time_ns) {
    v1::StageTiming& timing = *out.add_stages();
    timing.set_stage(stage);
    timing.set_last_ns(time_ns);
  };
  for (std::size_t k = 0; k < kStages; ++k) add(static_cast<v1::Stage>(k + 1), times[k]);
  add(v1::STAGE_SIMULATION, simulation_ns(times));
}

void encode_tool_sections(const ToolTick& tool, const StateRequest& request, v1::State& state) {
  if (wants(request, v1::SECTION_TOOLS)) encode_tool(tool, *state.add_tools());
  if (wants(request, v1::SECTION_DEVICES)) encode_device(tool, *state.add_devices());
  if (wants(request, v1::SECTION_STIFFNESS)) {
    v1::StiffnessState& stiffness = *state.add_stiffness();
    stiffness.set_tool_id(tool.tool_id);
    stiffness.set_scale(static_cast<float>(tool.stiffness.scale));
    stiffness.set_bound_n_per_m(static_cast<float>(tool.stiffness.bound));
    stiffness.set_delay_s(static_cast<float>(tool.stiffness.delay));
  }
  if (wants(request, v1::SECTION_GESTURES) && tool.gesture.plays) {
    v1::GestureState& gesture = *state.add_gestures();
    gesture.set_tool_id(tool.tool_id);
    gesture.set_name(tool.gesture.name.data());
    gesture.set_progress(static_cast<float>(tool.gesture.progress));
    gesture.set_repeated_count(tool.gesture.repeats);
  }
}

}  // namespace

void encode_state(const Tick& tick, const SceneIndex& index, const StateRequest& request,
                  v1::State& state) {
  state.Clear();
  state.set_tick(tick.tick);
  state.set_t_ns(static_cast<std::uint64_t>(std::max<std::int64_t>(tick.t_ns, 0)));
  state.set_loop_state(static_cast<v1::LoopState>(tick.state));
  state.set_cause(static_cast<v1::Cause>(tick.cause));
  state.set_scene_id(tick.scene_id);
  state.set_settling(tick.settling);
  for (const ToolTick& tool : tick.tools) encode_tool_sections(tool, request, state);
  if (wants(request, v1::SECTION_STRINGS)) encode_strings(tick, index, state);
  if (wants(request, v1::SECTION_CONTACTS)) {
    encode_contacts(tick, index, request.max_contacts, state);
  }
  if (wants(request, v1::SECTION_ENERGY)) encode_energy(tick, *state.mutable_energy());
  if (wants(request, v1::SECTION_QUALITY)) encode_quality(tick, *state.mutable_quality());
  if (wants(request, v1::SECTION_STAGES)) {
    encode_stages(tick.times.stages, *state.mutable_timing());
  }
}

}  // namespace hapticd
