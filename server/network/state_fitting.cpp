// See state_fitting.h.
#include "server/network/state_fitting.h"

#include <algorithm>
#include <set>
#include <utility>

namespace hapticd {
namespace {

/// One contact of a State: entry `entry` of the columns of patch `patch`.
struct ListedContact {
  int patch = 0;
  int entry = 0;
  std::int32_t gap_nanometres = 0;
};

/// Whether the columns agree, so that an entry can be taken out.
bool is_whole(const v1::ContactPatch& patch) {
  const int n = patch.gap_nanometres_size();
  return patch.tool_sphere_size() == n && patch.p_wc_um_size() == 3 * n &&
         patch.nhat_og_w_e4_size() == 3 * n && patch.force_mn_size() == n;
}

/// Contacts of all patches, smallest gap first; ties in the order of the State.
std::vector<ListedContact> by_depth(const v1::State& state) {
  std::vector<ListedContact> all;
  for (int p = 0; p < state.contacts_size(); ++p) {
    if (!is_whole(state.contacts(p))) continue;
    for (int i = 0; i < state.contacts(p).gap_nanometres_size(); ++i) {
      all.push_back({p, i, state.contacts(p).gap_nanometres(i)});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const ListedContact& a, const ListedContact& b) {
    return a.gap_nanometres < b.gap_nanometres;
  });
  return all;
}

/// Strings, largest growth of the radius first; ties by index.
std::vector<int> by_growth(const v1::State& state, std::span<const double> rest_radii_m) {
  const auto growth = [&](int i) {
    const v1::StringState& string = state.strings(i);
    const std::size_t index = string.string_index();
    const double rest = index < rest_radii_m.size() ? rest_radii_m[index] : 0.0;
    return static_cast<double>(string.radius_m()) - rest;
  };
  std::vector<std::pair<double, int>> keyed;
  keyed.reserve(static_cast<std::size_t>(state.strings_size()));
  for (int i = 0; i < state.strings_size(); ++i) keyed.emplace_back(-growth(i), i);
  std::stable_sort(keyed.begin(), keyed.end());
  std::vector<int> order;
  order.reserve(keyed.size());
  for (const auto& [key, i] : keyed) order.push_back(i);
  return order;
}

/// `from` with its first `kept` contacts in the order of `order`; a patch goes with its last one.
void put_contacts(const v1::State& from, const std::vector<ListedContact>& order, std::size_t kept,
                  v1::State& to) {
  std::vector<ListedContact> chosen(order.begin(),
                                    order.begin() + static_cast<std::ptrdiff_t>(kept));
  std::sort(chosen.begin(), chosen.end(), [](const ListedContact& a, const ListedContact& b) {
    return std::pair(a.patch, a.entry) < std::pair(b.patch, b.entry);
  });
  to.clear_contacts();
  int last = -1;
  for (const ListedContact& contact : chosen) {
    const v1::ContactPatch& source = from.contacts(contact.patch);
    if (contact.patch != last) {
      v1::ContactPatch& patch = *to.add_contacts();
      patch = source;
      patch.clear_tool_sphere();
      patch.clear_p_wc_um();
      patch.clear_nhat_og_w_e4();
      patch.clear_gap_nanometres();
      patch.clear_force_mn();
      last = contact.patch;
    }
    v1::ContactPatch& patch = *to.mutable_contacts(to.contacts_size() - 1);
    patch.add_tool_sphere(source.tool_sphere(contact.entry));
    patch.add_gap_nanometres(source.gap_nanometres(contact.entry));
    patch.add_force_mn(source.force_mn(contact.entry));
    for (int k = 3 * contact.entry; k < 3 * contact.entry + 3; ++k) {
      patch.add_p_wc_um(source.p_wc_um(k));
      patch.add_nhat_og_w_e4(source.nhat_og_w_e4(k));
    }
  }
}

/// `from` with its first `kept` strings in the order of `order`, listed as they were.
void put_strings(const v1::State& from, const std::vector<int>& order, std::size_t kept,
                 v1::State& to) {
  std::vector<int> chosen(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept));
  std::sort(chosen.begin(), chosen.end());
  to.clear_strings();
  for (const int i : chosen) *to.add_strings() = from.strings(i);
}

/// Strings of `state` whose sounding is repeated in it, in the order they are listed.
std::vector<int> sounding_strings(const v1::State& state) {
  std::vector<int> order;
  for (int i = 0; i < state.strings_size(); ++i) {
    if (state.strings(i).has_sounding()) order.push_back(i);
  }
  return order;
}

/// `from` with the first `kept` soundings of `order`.
void put_soundings(const v1::State& from, const std::vector<int>& order, std::size_t kept,
                   v1::State& to) {
  for (std::size_t k = 0; k < order.size(); ++k) {
    v1::StringState& string = *to.mutable_strings(order[k]);
    if (k < kept) {
      *string.mutable_sounding() = from.strings(order[k]).sounding();
    } else {
      string.clear_sounding();
    }
  }
}

/// The largest count in [0, most] with which put(count) fits; 0 if none does. put(count) was called
/// last with the result.
template <typename Put>
std::size_t largest_that_fits(std::size_t most, std::size_t bytes, const v1::State& state,
                              const Put& put) {
  std::size_t low = 0;
  std::size_t high = most;
  while (low < high) {
    const std::size_t middle = (low + high + 1) / 2;
    put(middle);
    if (state.ByteSizeLong() <= bytes) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  put(low);
  return low;
}

/// Leaves out soundings until `state` fits, all but one: contacts make way for that, so that what
/// sounds is told, one string after the other, however many contacts there are.
bool trim_soundings(v1::State& state, std::size_t bytes) {
  const std::vector<int> order = sounding_strings(state);
  if (order.size() > 1) {
    const v1::State whole = state;
    const auto put = [&](std::size_t kept) { put_soundings(whole, order, kept, state); };
    if (largest_that_fits(order.size(), bytes, state, put) == 0) put(1);
  }
  return state.ByteSizeLong() <= bytes;
}

/// Leaves out soundings, then contacts, then strings, until `state` fits; false if it does not even
/// without them.
bool trim(v1::State& state, std::size_t bytes, std::span<const double> rest_radii_m) {
  if (state.ByteSizeLong() <= bytes || trim_soundings(state, bytes)) return true;
  const v1::State whole = state;
  const std::vector<ListedContact> contacts = by_depth(whole);
  if (!contacts.empty() || whole.contacts_size() > 0) {
    if (!state.has_contacts_total()) {
      state.set_contacts_total(static_cast<std::uint32_t>(contacts.size()));
    }
    largest_that_fits(contacts.size(), bytes, state,
                      [&](std::size_t kept) { put_contacts(whole, contacts, kept, state); });
    if (state.ByteSizeLong() <= bytes) return true;
  }
  if (whole.strings_size() > 0) {
    const std::vector<int> strings = by_growth(whole, rest_radii_m);
    if (!state.has_strings_total()) {
      state.set_strings_total(static_cast<std::uint32_t>(strings.size()));
    }
    largest_that_fits(strings.size(), bytes, state,
                      [&](std::size_t kept) { put_strings(whole, strings, kept, state); });
  }
  return state.ByteSizeLong() <= bytes;
}

/// Every tool that some entry of `state` belongs to, ascending.
std::set<std::uint32_t> tools_of(const v1::State& state) {
  std::set<std::uint32_t> ids;
  for (const auto& entry : state.tools()) ids.insert(entry.tool_id());
  for (const auto& entry : state.devices()) ids.insert(entry.tool_id());
  for (const auto& entry : state.contacts()) ids.insert(entry.tool_id());
  for (const auto& entry : state.energy().tools()) ids.insert(entry.tool_id());
  for (const auto& entry : state.stiffness()) ids.insert(entry.tool_id());
  for (const auto& entry : state.gestures()) ids.insert(entry.tool_id());
  return ids;
}

template <typename Entries>
void copy_entries(const Entries& from, std::uint32_t id, Entries& to) {
  for (const auto& entry : from) {
    if (entry.tool_id() == id) *to.Add() = entry;
  }
}

/// Copies the entries of tool `id` but its contacts.
void copy_tool(const v1::State& from, std::uint32_t id, v1::State& to) {
  copy_entries(from.tools(), id, *to.mutable_tools());
  copy_entries(from.devices(), id, *to.mutable_devices());
  copy_entries(from.stiffness(), id, *to.mutable_stiffness());
  copy_entries(from.gestures(), id, *to.mutable_gestures());
  if (from.energy().tools_size() == 0) return;
  copy_entries(from.energy().tools(), id, *to.mutable_energy()->mutable_tools());
}

/// What every part has.
v1::State part_of(const v1::State& whole) {
  v1::State part;
  part.set_tick(whole.tick());
  part.set_t_ns(whole.t_ns());
  part.set_loop_state(whole.loop_state());
  part.set_cause(whole.cause());
  part.set_scene_id(whole.scene_id());
  // As long as these get in any part.
  part.set_part_index(31);
  part.set_part_count(32);
  return part;
}

/// The first part, without tools: everything that belongs to none.
v1::State first_part_of(const v1::State& whole) {
  v1::State part = whole;
  part.clear_tools();
  part.clear_devices();
  part.clear_contacts();
  part.clear_strings();
  if (part.has_energy()) part.mutable_energy()->clear_tools();
  part.clear_stiffness();
  part.clear_gestures();
  if (whole.contacts_size() > 0 && !part.has_contacts_total()) {
    part.set_contacts_total(static_cast<std::uint32_t>(by_depth(whole).size()));
  }
  if (whole.strings_size() > 0 && !part.has_strings_total()) {
    part.set_strings_total(static_cast<std::uint32_t>(whole.strings_size()));
  }
  part.set_part_index(31);
  part.set_part_count(32);
  return part;
}

/// Totals say that something is missing: they go where nothing is.
void drop_needless_totals(const v1::State& whole, std::vector<v1::State>& parts) {
  std::size_t listed = 0;
  for (const v1::State& part : parts) listed += by_depth(part).size();
  v1::State& first = parts.front();
  if (!whole.has_contacts_total() && listed == first.contacts_total()) first.clear_contacts_total();
  if (!whole.has_strings_total() &&
      static_cast<std::uint32_t>(first.strings_size()) == first.strings_total()) {
    first.clear_strings_total();
  }
}

std::vector<v1::State> split(const v1::State& whole, std::size_t bytes,
                             std::span<const double> rest_radii_m) {
  // Tools in the order of their ids, each into the last part if it fits there without contacts. The
  // first part may stay without a tool.
  std::vector<v1::State> bare{first_part_of(whole)};
  std::vector<std::vector<std::uint32_t>> members(1);
  for (const std::uint32_t id : tools_of(whole)) {
    v1::State longer = bare.back();
    copy_tool(whole, id, longer);
    if (longer.ByteSizeLong() > bytes && (!members.back().empty() || bare.size() == 1)) {
      bare.push_back(part_of(whole));
      members.emplace_back();
      longer = bare.back();
      copy_tool(whole, id, longer);
    }
    bare.back() = std::move(longer);
    members.back().push_back(id);
  }
  // Then as many contacts of its tools as each part holds, and strings in the first.
  for (std::size_t i = 0; i < bare.size(); ++i) {
    v1::State& part = bare[i];
    for (const auto& patch : whole.contacts()) {
      if (std::count(members[i].begin(), members[i].end(), patch.tool_id()) > 0) {
        *part.add_contacts() = patch;
      }
    }
    if (i == 0) *part.mutable_strings() = whole.strings();
    const bool had_total = part.has_contacts_total();
    trim(part, bytes, rest_radii_m);
    if (!had_total) part.clear_contacts_total();
    part.set_part_index(static_cast<std::uint32_t>(i));
    part.set_part_count(static_cast<std::uint32_t>(bare.size()));
  }
  drop_needless_totals(whole, bare);
  return bare;
}

}  // namespace

std::optional<std::uint32_t> soundings_left(const v1::State& whole, const v1::State& first) {
  const std::vector<int> wanted = sounding_strings(whole);
  const std::vector<int> told = sounding_strings(first);
  // Those that fit are the first of all, so the next is the one after the last of them.
  const std::uint32_t last = told.empty() ? 0 : first.strings(told.back()).string_index();
  for (std::size_t k = told.empty() ? 1 : 0; k < wanted.size(); ++k) {
    const std::uint32_t index = whole.strings(wanted[k]).string_index();
    if (told.empty() || index > last) return index;
  }
  return std::nullopt;
}

std::vector<v1::State> fit_state(const v1::State& state, std::size_t bytes,
                                 std::span<const double> rest_radii_m) {
  v1::State trimmed = state;
  if (trim(trimmed, bytes, rest_radii_m)) return {std::move(trimmed)};
  return split(state, bytes, rest_radii_m);
}

}  // namespace hapticd
