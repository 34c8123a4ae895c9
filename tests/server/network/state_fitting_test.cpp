// What is left out of a State that is too long, and in which order. PROTOCOL.md, section 6.
#include "server/network/state_fitting.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kBytes = 1080;

void add_contact(v1::ContactPatch& patch, std::int32_t gap, std::int32_t sphere) {
  patch.add_tool_sphere(sphere);
  patch.add_gap_nanometres(gap);
  patch.add_force_mn(1000);
  for (int k = 0; k < 3; ++k) {
    patch.add_p_wc_um(500'000 + sphere);
    patch.add_nhat_og_w_e4(5000);
  }
}

v1::ToolState& add_tool(v1::State& state, std::uint32_t id) {
  v1::ToolState& tool = *state.add_tools();
  tool.set_tool_id(id);
  for (int k = 0; k < 3; ++k) {
    tool.add_p_wh_m(0.1);
    tool.add_p_wg_m(0.1);
  }
  for (int k = 0; k < 4; ++k) {
    tool.add_q_wh(0.5F);
    tool.add_q_wg(0.5F);
  }
  for (int k = 0; k < 6; ++k) tool.add_wrench_h_w(1.0F);
  return tool;
}

/// Gaps of all contacts by sphere.
std::map<std::int32_t, std::int32_t> contacts_of(const v1::State& state) {
  std::map<std::int32_t, std::int32_t> gaps;
  for (const v1::ContactPatch& patch : state.contacts()) {
    const int n = patch.tool_sphere_size();
    CHECK(n > 0);
    CHECK(patch.p_wc_um_size() == 3 * n);
    CHECK(patch.nhat_og_w_e4_size() == 3 * n);
    CHECK(patch.gap_nanometres_size() == n);
    CHECK(patch.force_mn_size() == n);
    for (int i = 0; i < n; ++i) {
      gaps[patch.tool_sphere(i)] = patch.gap_nanometres(i);
      CHECK(patch.p_wc_um(3 * i + 2) == 500'000 + patch.tool_sphere(i));
    }
  }
  return gaps;
}

v1::State random_state(SplitMix64& random) {
  v1::State state;
  state.set_tick(random.below(1'000'000));
  state.set_scene_id(1);
  const auto tools = static_cast<std::uint32_t>(1 + random.below(4));
  std::int32_t sphere = 0;
  for (std::uint32_t id = 0; id < tools; ++id) {
    add_tool(state, id);
    for (std::uint64_t p = random.below(3); p > 0; --p) {
      v1::ContactPatch& patch = *state.add_contacts();
      patch.set_tool_id(id);
      patch.set_string_index(static_cast<std::uint32_t>(p));
      for (int k = 0; k < 3; ++k) patch.add_force_w_n(1.0F);
      for (std::uint64_t n = 1 + random.below(40); n > 0; --n) {
        add_contact(patch, static_cast<std::int32_t>(random.below(100'000)) - 50'000, sphere++);
      }
    }
  }
  for (std::uint64_t n = random.below(40); n > 0; --n) {
    v1::StringState& string = *state.add_strings();
    string.set_string_index(static_cast<std::uint32_t>(n));
    string.set_radius_m(static_cast<float>(random.uniform(0.001, 0.01)));
  }
  return state;
}

TEST_CASE("a State that fits is left as it is") {
  v1::State state;
  add_tool(state, 3);
  const auto fitted = fit_state(state, kBytes, {});
  REQUIRE(fitted.size() == 1);
  CHECK(fitted[0].SerializeAsString() == state.SerializeAsString());
}

TEST_CASE("contacts are left out largest gap first, as few as possible, and counted") {
  SplitMix64 random(12);
  int cut = 0;
  for (std::int64_t trial = scaled(3000); trial > 0; --trial) {
    v1::State state = random_state(random);
    state.clear_strings();
    const auto before = contacts_of(state);
    const auto fitted = fit_state(state, kBytes, {});
    REQUIRE(fitted.size() == 1);
    CHECK(fitted[0].ByteSizeLong() <= kBytes);
    const auto after = contacts_of(fitted[0]);
    CHECK(fitted[0].has_contacts_total() == (after.size() < before.size()));
    if (after.size() == before.size()) continue;
    ++cut;
    CHECK(fitted[0].contacts_total() == before.size());
    std::int32_t largest_kept = -50'001;
    for (const auto& [sphere, gap] : after) largest_kept = std::max(largest_kept, gap);
    std::int32_t smallest_dropped = 50'001;
    for (const auto& [sphere, gap] : before) {
      if (after.count(sphere) == 0) smallest_dropped = std::min(smallest_dropped, gap);
    }
    CHECK(largest_kept <= smallest_dropped);
    // Not a contact less than needed: one more is some 30 bytes, a new patch some 20 beside.
    CHECK(fitted[0].ByteSizeLong() + 60 > kBytes);
  }
  CHECK((cut > 0 || scaled(3000) < 10));
}

TEST_CASE("strings are left out when all contacts are, those nearest to rest first") {
  v1::State state;
  for (std::uint32_t i = 0; i < 100; ++i) {
    v1::StringState& string = *state.add_strings();
    string.set_string_index(i);
    string.set_radius_m(0.01F);
    for (int k = 0; k < 3; ++k) string.add_deflection_w_m(0.1F);
  }
  v1::ContactPatch& patch = *state.add_contacts();
  for (int k = 0; k < 3; ++k) patch.add_force_w_n(1.0F);
  add_contact(patch, 5, 1);
  std::vector<double> rest_radii_m;
  rest_radii_m.reserve(100);
  for (int i = 0; i < 100; ++i) rest_radii_m.push_back(0.01 - 1e-5 * ((i * 37) % 100));
  const auto fitted = fit_state(state, kBytes, rest_radii_m);
  REQUIRE(fitted.size() == 1);
  CHECK(fitted[0].contacts_size() == 0);
  CHECK(fitted[0].contacts_total() == 1);
  CHECK(fitted[0].strings_total() == 100);
  const int kept = fitted[0].strings_size();
  CHECK(kept > 10);
  // Growth of string i is 1e-5 (37 i mod 100): exactly the `kept` largest are there, in order.
  std::uint32_t last = 0;
  for (const v1::StringState& string : fitted[0].strings()) {
    CHECK((string.string_index() * 37) % 100 >= static_cast<std::uint32_t>(100 - kept));
    CHECK((string.string_index() > last || string.string_index() == 0));
    last = string.string_index();
  }
}

TEST_CASE("totals the host has set are kept") {
  v1::State state;
  v1::ContactPatch& patch = *state.add_contacts();
  for (int i = 0; i < 100; ++i) add_contact(patch, i, i);
  state.set_contacts_total(400);
  const auto fitted = fit_state(state, kBytes, {});
  CHECK(fitted[0].contacts_total() == 400);
}

TEST_CASE(
    "tools that do not fit are spread over parts: each in one, everything else in the first") {
  v1::State state;
  state.set_tick(9);
  state.set_t_ns(9'000'000);
  state.set_scene_id(2);
  state.set_loop_state(v1::LOOP_STATE_ENGAGED);
  state.mutable_timing()->set_last_ns(5);
  state.mutable_energy()->set_strings_j(1.0F);
  std::size_t spheres = 0;
  for (std::uint32_t id = 0; id < 32; ++id) {
    add_tool(state, id * 3);
    state.add_stiffness()->set_tool_id(id * 3);
    state.mutable_energy()->add_tools()->set_tool_id(id * 3);
    v1::ContactPatch& patch = *state.add_contacts();
    patch.set_tool_id(id * 3);
    add_contact(patch, 7, static_cast<std::int32_t>(spheres++));
  }
  const auto parts = fit_state(state, kBytes, {});
  REQUIRE(parts.size() > 3);
  std::multiset<std::uint32_t> tools;
  std::multiset<std::uint32_t> energies;
  std::size_t contacts = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const v1::State& part = parts[i];
    CHECK(part.ByteSizeLong() <= kBytes);
    CHECK(part.tick() == 9);
    CHECK(part.t_ns() == 9'000'000);
    CHECK(part.scene_id() == 2);
    CHECK(part.loop_state() == v1::LOOP_STATE_ENGAGED);
    CHECK(part.part_index() == i);
    CHECK(part.part_count() == parts.size());
    CHECK(part.has_timing() == (i == 0));
    CHECK((part.energy().strings_j() == 1.0F) == (i == 0));
    std::set<std::uint32_t> here;
    for (const auto& tool : part.tools()) tools.insert(tool.tool_id());
    for (const auto& tool : part.tools()) here.insert(tool.tool_id());
    for (const auto& tool : part.energy().tools()) energies.insert(tool.tool_id());
    for (const auto& entry : part.stiffness()) CHECK(here.count(entry.tool_id()) == 1);
    for (const auto& patch : part.contacts()) CHECK(here.count(patch.tool_id()) == 1);
    contacts += contacts_of(part).size();
  }
  CHECK(tools.size() == 32);
  CHECK(std::set<std::uint32_t>(tools.begin(), tools.end()).size() == 32);
  CHECK(energies.size() == 32);
  CHECK(parts[0].has_contacts_total() == (contacts < spheres));
}

TEST_CASE("a patch whose columns disagree does no harm") {
  v1::State state;
  v1::ContactPatch& patch = *state.add_contacts();
  for (int i = 0; i < 200; ++i) add_contact(patch, i, i);
  patch.mutable_p_wc_um()->RemoveLast();
  const auto fitted = fit_state(state, kBytes, {});
  REQUIRE(fitted.size() == 1);
  CHECK(fitted[0].ByteSizeLong() <= kBytes);
}

}  // namespace
}  // namespace hapticd::test
