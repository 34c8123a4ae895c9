// See state_record.h.
#include "server/recorder/state_record.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "core/simulation/simulation_fields.h"
#include "server/haptic_loop/settings_change.h"

namespace hapticd {
namespace {

/// In the order of StateKind.
constexpr std::array<std::string_view, 10> kBlockNames{
    "loop", "settings",  "ramp.from", "ramp.to", "simulation",
    "tool", "tool.loop", "string",    "push",    "measuring"};

/// Oldest layout whose settings can be read.
constexpr std::uint32_t kSettingsLayout = 2;
/// Oldest layout whose strings have an axial stiffness, a tuning and a loss of high modes.
constexpr std::uint32_t kStringLayout = 5;

/// Blocks of each kind so far.
using BlocksSeen = std::array<std::uint32_t, kBlockNames.size()>;

bool of_tool(StateKind kind) noexcept {
  return kind != StateKind::kLoop && kind != StateKind::kSimulation && kind != StateKind::kString;
}

template <typename T>
bool same_bits(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

std::string describe(const StateSpan& block) {
  std::string text(block_name(block.kind));
  if (block.kind == StateKind::kString) text += " " + std::to_string(block.index);
  if (of_tool(block.kind)) text += " of tool " + std::to_string(block.index);
  return text;
}

/// Kind, and number among its like, of the next block; false when it is not known.
bool name_block(const v1::StateBlock& from, BlocksSeen& seen, StateSpan& block) {
  const auto* const name = std::find(kBlockNames.begin(), kBlockNames.end(), from.name());
  if (name == kBlockNames.end() || from.version() != kStateLayout) return false;
  const auto kind = static_cast<std::size_t>(name - kBlockNames.begin());
  block.kind = static_cast<StateKind>(kind);
  block.index = block.kind == StateKind::kString ? from.string_index() : seen[kind]++;
  return true;
}

/// Settings of tool `k`; those of the strings are with tool 0.
template <typename Settings, typename Visit>
void visit_settings(Settings& settings, std::size_t k, Visit& visit) {
  visit(settings.tools[k]);
  if (k != 0) return;
  for (auto& piece : settings.pieces) visit(piece);
}

/// A string of a layout before kStringLayout; what that has not stays as the scene says.
void read_former(StringParameters& string, StateReader& read) {
  read(string.p_WA, string.p_WB, string.radius, string.tension, string.youngs_modulus,
       string.linear_density, string.frequency, string.decay, string.touch_decay);
  read.bounded(string.model, 0, static_cast<int>(kMaxStringContact));
  read(string.k_s, string.contact_stiffness, string.inharmonicity, string.friction_coefficient);
  read.bounded(string.max_level, 0, static_cast<int>(StringDetail::kModes));
}

/// Settings of tool `k` as a layout before kStringLayout has them.
void read_former(SceneSettings& settings, std::size_t k, StateReader& read) {
  read(settings.tools[k]);
  if (k != 0) return;
  for (StringParameters& piece : settings.pieces) read_former(piece, read);
}

}  // namespace

std::string_view block_name(StateKind kind) noexcept {
  return kBlockNames[static_cast<std::size_t>(kind)];
}

void to_record(const Snapshot& snapshot, v1::Snapshot& record) {
  record.Clear();
  record.set_next_tick(snapshot.next_tick);
  record.set_scene_id(snapshot.scene_id);
  record.set_loop_state(static_cast<v1::LoopState>(snapshot.loop_state));
  for (const StateSpan& span : snapshot.blocks) {
    v1::StateBlock& block = *record.add_blocks();
    block.set_name(std::string(block_name(span.kind)));
    block.set_version(kStateLayout);
    if (of_tool(span.kind)) block.set_tool_id(snapshot.tool_ids[span.index]);
    if (span.kind == StateKind::kString) block.set_string_index(span.index);
    const auto reals = snapshot.reals_of(span);
    const auto integers = snapshot.integers_of(span);
    block.mutable_reals()->Add(reals.begin(), reals.end());
    block.mutable_integers()->Add(integers.begin(), integers.end());
  }
  record.set_state_hash(hash_of(snapshot));
}

bool is_of_older_layout(const v1::Snapshot& record) {
  return std::any_of(record.blocks().begin(), record.blocks().end(),
                     [](const v1::StateBlock& block) { return block.version() < kStateLayout; });
}

bool to_snapshot(const v1::Snapshot& record, Snapshot& snapshot) {
  snapshot.blocks.clear();
  snapshot.next_tick = record.next_tick();
  snapshot.scene_id = record.scene_id();
  snapshot.loop_state = static_cast<LoopState>(record.loop_state());
  std::size_t reals = 0;
  std::size_t integers = 0;
  BlocksSeen seen{};
  for (const v1::StateBlock& from : record.blocks()) {
    StateSpan block;
    block.first_real = static_cast<std::uint32_t>(reals);
    block.first_integer = static_cast<std::uint32_t>(integers);
    block.reals = static_cast<std::uint32_t>(from.reals_size());
    block.integers = static_cast<std::uint32_t>(from.integers_size());
    if (!name_block(from, seen, block) || reals + block.reals > snapshot.reals.size() ||
        integers + block.integers > snapshot.integers.size() || !snapshot.blocks.push_back(block)) {
      return false;
    }
    std::copy(from.reals().begin(), from.reals().end(), snapshot.reals.begin() + block.first_real);
    std::copy(from.integers().begin(), from.integers().end(),
              snapshot.integers.begin() + block.first_integer);
    reals += block.reals;
    integers += block.integers;
  }
  return true;
}

std::string first_difference(const Snapshot& recorded, const Snapshot& replayed) {
  const std::size_t common = std::min(recorded.blocks.size(), replayed.blocks.size());
  for (std::size_t k = 0; k < common; ++k) {
    const StateSpan& a = recorded.blocks[k];
    const StateSpan& b = replayed.blocks[k];
    if (a.kind != b.kind || a.index != b.index ||
        !same_bits(recorded.reals_of(a), replayed.reals_of(b)) ||
        !same_bits(recorded.integers_of(a), replayed.integers_of(b))) {
      return describe(a);
    }
  }
  if (recorded.blocks.size() != replayed.blocks.size()) return "number of blocks";
  if (recorded.next_tick != replayed.next_tick) return "next tick";
  return "";
}

void put_settings(const SceneSettings& settings, v1::ParameterRecord& record) {
  constexpr std::size_t kMaxPerPiece = 32;
  constexpr std::size_t kMaxPerTool = 128;
  const std::size_t room = kMaxPerTool + kMaxPerPiece * settings.pieces.size();
  std::vector<double> reals(room);
  std::vector<std::int64_t> integers(room);
  for (std::size_t k = 0; k < settings.tools.size(); ++k) {
    StateWriter write({reals, integers});
    visit_settings(settings, k, write);
    HD_ASSERT(write.good());
    v1::StateBlock& block = *record.add_settings();
    block.set_name(std::string(block_name(StateKind::kSettings)));
    block.set_version(kStateLayout);
    block.mutable_reals()->Add(reals.begin(),
                               reals.begin() + static_cast<std::ptrdiff_t>(write.reals()));
    block.mutable_integers()->Add(integers.begin(),
                                  integers.begin() + static_cast<std::ptrdiff_t>(write.integers()));
  }
}

bool get_settings(const v1::ParameterRecord& record, SceneSettings& settings) {
  if (static_cast<std::size_t>(record.settings_size()) != settings.tools.size()) return false;
  for (std::size_t k = 0; k < settings.tools.size(); ++k) {
    const v1::StateBlock& block = record.settings(static_cast<int>(k));
    if (block.version() < kSettingsLayout || block.version() > kStateLayout) return false;
    StateReader read({block.reals().data(), static_cast<std::size_t>(block.reals_size())},
                     {block.integers().data(), static_cast<std::size_t>(block.integers_size())});
    if (block.version() < kStringLayout) {
      read_former(settings, k, read);
    } else {
      visit_settings(settings, k, read);
    }
    if (!read.complete()) return false;
  }
  return usable(settings);
}

}  // namespace hapticd
