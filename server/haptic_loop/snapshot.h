// Everything the loop keeps between two ticks, as plain numbers on their way from the haptic thread
// to the recorder's thread, block by block: it becomes a v1::Snapshot, and a replay starts from it.
// Filled in place once a second (loop_snapshot.cpp). RT: yes, plain data; 6 MB, of which a scene
// uses what its strings need.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "core/math/fixed_vector.h"
#include "core/math/limits.h"
#include "core/math/state_fields.h"
#include "core/rt/spsc_ring.h"
#include "core/safety/loop_state.h"

namespace hapticd {

/// What a block is of. Blocks of the same kind are numbered.
enum class StateKind : std::uint8_t {
  kLoop,        ///< instants, state machine, watch of late ticks
  kSettings,    ///< in force, of a tool; those of strings with tool 0
  kRampFrom,    ///< where a change of settings that is under way began, likewise
  kRampTo,      ///< and leads to
  kSimulation,  ///< what all tools share: which strings are awake
  kTool,        ///< of the simulation
  kToolLoop,    ///< of the loop: pose guard, safety stage, workspace, touches
  kString,      ///< its vibration and touch, as every tool sees it
  kPush,        ///< of a tool: its push of the guided check; left out while no tool has one
  kMeasuring,   ///< of a tool: the spring its damping is measured with, likewise
};

/// Layout of every block; grows with any change of what is visited.
inline constexpr std::uint32_t kStateLayout = 7;

/// Numbers of each sort, at most: 1024 strings with 64 modes in two planes, and five tools.
inline constexpr std::size_t kMaxStateNumbers = 524'288;
/// Blocks, at most: 1024 strings, and some for each tool.
inline constexpr std::size_t kMaxStateBlocks = 1024 + 8 * kMaxTools;

/// Where the numbers of a block are.
struct StateSpan {
  StateKind kind = StateKind::kLoop;
  std::uint32_t index = 0;  ///< tool in the scene's order, or string
  std::uint32_t first_real = 0;
  std::uint32_t reals = 0;
  std::uint32_t first_integer = 0;
  std::uint32_t integers = 0;
};

struct Snapshot {
  std::uint64_t next_tick = 0;
  std::uint32_t scene_id = 0;
  LoopState loop_state = LoopState::kDetached;
  std::array<std::uint32_t, kMaxTools> tool_ids{};  ///< in the scene's order
  FixedVector<StateSpan, kMaxStateBlocks> blocks;
  std::array<double, kMaxStateNumbers> reals{};
  std::array<std::int64_t, kMaxStateNumbers> integers{};

  [[nodiscard]] std::span<const double> reals_of(const StateSpan& block) const noexcept {
    return {reals.data() + block.first_real, block.reals};
  }
  [[nodiscard]] std::span<const std::int64_t> integers_of(const StateSpan& block) const noexcept {
    return {integers.data() + block.first_integer, block.integers};
  }
};
static_assert(std::is_trivially_copyable_v<Snapshot>);

/// Snapshots on their way to the recorder.
using SnapshotRing = SpscRing<Snapshot, 2>;

/// Appends blocks to a snapshot.
class SnapshotWriter {
 public:
  explicit SnapshotWriter(Snapshot& snapshot) noexcept : snapshot_(snapshot) {
    snapshot_.blocks.clear();
  }

  /// The fields of `parts`, in order, as one block.
  template <typename... Parts>
  HD_REALTIME void add(StateKind kind, std::uint32_t index, const Parts&... parts) noexcept {
    StateWriter write({std::span(snapshot_.reals).subspan(reals_),
                       std::span(snapshot_.integers).subspan(integers_)});
    write(parts...);
    good_ = good_ && write.good() &&
            snapshot_.blocks.push_back({kind, index, static_cast<std::uint32_t>(reals_),
                                        static_cast<std::uint32_t>(write.reals()),
                                        static_cast<std::uint32_t>(integers_),
                                        static_cast<std::uint32_t>(write.integers())});
    if (!good_) return;
    reals_ += write.reals();
    integers_ += write.integers();
  }

  /// False when something did not fit: the snapshot is of no use.
  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  Snapshot& snapshot_;
  std::size_t reals_ = 0;
  std::size_t integers_ = 0;
  bool good_ = true;
};

/// Takes blocks of a snapshot back.
class SnapshotReader {
 public:
  explicit SnapshotReader(const Snapshot& snapshot) noexcept : snapshot_(snapshot) {}

  /// The fields of `parts`, in order, from the block of this kind and index. What is missing, too
  /// long, too short or out of range makes good() false.
  template <typename... Parts>
  void take(StateKind kind, std::uint32_t index, Parts&... parts) noexcept {
    const StateSpan* block = find(kind, index);
    if (block == nullptr) {
      good_ = false;
      return;
    }
    StateReader read(snapshot_.reals_of(*block), snapshot_.integers_of(*block));
    read(parts...);
    good_ = good_ && read.complete();
  }
  /// Null: there is none.
  [[nodiscard]] const StateSpan* find(StateKind kind, std::uint32_t index) const noexcept {
    for (const StateSpan& block : snapshot_.blocks) {
      if (block.kind == kind && block.index == index) return &block;
    }
    return nullptr;
  }
  void require(bool right) noexcept { good_ = good_ && right; }
  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  const Snapshot& snapshot_;
  bool good_ = true;
};

/// Hash of all blocks in their order, as Snapshot.state_hash.
[[nodiscard]] inline std::uint64_t hash_of(const Snapshot& snapshot) noexcept {
  std::uint64_t hash = kStateHashStart;
  for (const StateSpan& block : snapshot.blocks) {
    hash = hash_numbers(hash, snapshot.reals_of(block), snapshot.integers_of(block));
  }
  return hash;
}

}  // namespace hapticd
