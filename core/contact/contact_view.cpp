// See contact_view.h. RT: yes.
#include "core/contact/contact_view.h"

namespace hapticd {

ContactRow contact_row(const ContactView& view, const Contact& contact) noexcept {
  const ContactState& state = view.state;
  const GapGradient gradient = view.strings.gradient(state, contact);
  ContactRow row;
  row.linear = gradient.linear;
  row.angular = gradient.angular;
  row.bound = -contact.gap;
  if (gradient.string >= 0) {
    const auto s = static_cast<std::size_t>(gradient.string);
    const StringBlock& block = view.strings.block(s);
    if (block.unknown >= 0) {
      const double share = deflection_share(state.touched[s].bend, contact.lambda);
      row.unknown = block.unknown;
      row.radial = -share * contact.nhat_OG_W.dot(block.radial_W);
      row.tangential = -share * contact.nhat_OG_W.dot(block.tangential_W);
    }
  }
  const int own = find_part(view.input.parts, state.parts, contact.key.tool_sphere);
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    const int unknown = view.parts.block(k).unknown;
    const bool is_own = own == static_cast<int>(k);
    if (unknown < 0 || (!is_own && gradient.slid == 0.0)) continue;
    row.part[row.parts++] = {static_cast<std::size_t>(unknown),
                             view.strings.part_gradient(contact, gradient, k, is_own)};
  }
  return row;
}

}  // namespace hapticd
