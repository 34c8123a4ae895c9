// See phantom_contacts.h. RT: yes.
#include "core/contact/phantom_contacts.h"

#include <algorithm>
#include <array>

#include "core/contact/clearance.h"

namespace hapticd {
namespace {

/// Whether tool or hand is within a touch of the pair.
bool reached(const ContactView& view, const ContactKey& key) noexcept {
  const auto& [input, state] = view.at();
  const double touch = kTouchSkins * skin_of(input.options);
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  const double gap = evaluate_contact(key, {input.tool, state.X_WG, shape.view()}, bent.view()).gap;
  if (gap <= touch) return true;
  return evaluate_contact(key, {input.tool, input.X_WH, shape.view()}, input.obstacles).gap <=
         touch;
}

/// Takes the force of a pair off the tool's, which is about the origin of G before the step.
void take_off(const ContactView& view, const Vector3& p_WG, const ActiveContact& active,
              Wrench& F_H_W) noexcept {
  const Contact& contact = view.contact_of(active);
  const GapGradient gradient = view.strings.gradient(view.state, contact);
  const Vector3 moved = view.state.X_WG.p - p_WG;
  F_H_W.f -= active.multiplier * gradient.linear;
  F_H_W.t -= active.multiplier * (gradient.angular + moved.cross(contact.nhat_OG_W));
}

/// What a string without a contact may not do to the tool either.
void let_slide(const ContactView& view, std::size_t k, ContactState& state) noexcept {
  TouchedString& string = state.touched[k];
  state.F_H_W.f -= string.tangential_W;
  state.F_H_W.t -= view.strings.block(k).p_GC_W.cross(string.tangential_W);
  string.tangential_W = Vector3::Zero();
  string.normal_force = 0.0;
}

}  // namespace

void drop_phantoms(const ContactView& view, const BeforeStep& before, ContactState& state,
                   ContactResult& result) noexcept {
  std::array<bool, kMaxDeflectingStrings> lost{};
  int kept = 0;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact active = result.active[static_cast<std::size_t>(k)];
    const ContactKey& key = view.contact_of(active).key;
    const bool pressed =
        std::find(before.pressed.begin(), before.pressed.end(), key) != before.pressed.end();
    if (pressed || !(active.multiplier > 0.0) || reached(view, key)) {
      state.active[static_cast<std::size_t>(kept)] = state.active[static_cast<std::size_t>(k)];
      result.active[static_cast<std::size_t>(kept++)] = active;
      continue;
    }
    take_off(view, before.p_WG, active, state.F_H_W);
    const int string = find_touched(state.touched, key);
    if (string >= 0) lost[static_cast<std::size_t>(string)] = true;
  }
  if (kept == result.active_count) return;
  result.active_count = state.active_count = kept;
  for (int k = 0; k < kept; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const int string = find_touched(state.touched, state.active[i].key);
    if (string >= 0) lost[static_cast<std::size_t>(string)] = false;
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    if (lost[k]) let_slide(view, k, state);
  }
  if (kept == 0) state.F_H_W = Wrench{};
  result.F_H_W = state.F_H_W;
}

}  // namespace hapticd
