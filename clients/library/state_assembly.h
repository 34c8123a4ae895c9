// Puts the States of a session together: newest wins, several parts of one tick become one State,
// and each tick is given out once. PROTOCOL.md, section 6. Pure. Not RT.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "hapticd/v1/state.pb.h"

namespace hapticd::client {

/// What a client reports about the States it got, and the State it is putting together.
class StateAssembly {
 public:
  /// Packet.seen and Packet.newest.
  [[nodiscard]] std::uint64_t seen() const noexcept { return seen_; }
  [[nodiscard]] std::uint64_t newest() const noexcept { return newest_; }

  /// A State arrived; `is_newest`: in the datagram with the highest counter so far. The whole State
  /// of its tick, when this completes it.
  std::optional<v1::State> take(v1::State&& part, bool is_newest) {
    ++seen_;
    if (part.scene_id() > scene_id_) {
      scene_id_ = part.scene_id();
      newest_ = 0;
      any_given_ = false;
      parts_ = 0;
    }
    if (part.scene_id() < scene_id_) return std::nullopt;
    newest_ = std::max(newest_, part.tick());
    if (any_given_ && part.tick() <= given_tick_) return std::nullopt;
    if (part.part_count() <= 1) {
      if (!is_newest) return std::nullopt;
      return give(std::move(part));
    }
    return take_part(std::move(part), is_newest);
  }

 private:
  std::optional<v1::State> take_part(v1::State&& part, bool is_newest) {
    const bool continues = parts_ != 0 && part.tick() == assembled_.tick() &&
                           part.part_count() == assembled_.part_count();
    if (!continues && !is_newest) return std::nullopt;
    if (part.part_index() >= 32 || part.part_count() > 32) return std::nullopt;
    const std::uint32_t bit = 1U << part.part_index();
    const std::uint32_t all = part.part_count() == 32 ? ~0U : (1U << part.part_count()) - 1U;
    if ((bit & all) == 0 || (continues && (parts_ & bit) != 0)) return std::nullopt;
    if (continues) {
      parts_ |= bit;
      assembled_.MergeFrom(part);
    } else {
      parts_ = bit;
      assembled_ = std::move(part);
    }
    if (parts_ != all) return std::nullopt;
    parts_ = 0;
    assembled_.clear_part_index();
    assembled_.clear_part_count();
    return give(std::move(assembled_));
  }

  v1::State give(v1::State&& state) {
    any_given_ = true;
    given_tick_ = state.tick();
    return std::move(state);
  }

  std::uint64_t seen_ = 0;
  std::uint64_t newest_ = 0;
  std::uint32_t scene_id_ = 0;
  bool any_given_ = false;
  std::uint64_t given_tick_ = 0;
  v1::State assembled_;
  std::uint32_t parts_ = 0;  ///< bit i: part i is in assembled_
};

}  // namespace hapticd::client
