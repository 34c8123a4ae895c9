// The scene that plays, the one that waits to take its place, and the one that has played and is
// not given back yet. RT: yes.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "core/math/assert.h"
#include "server/haptic_loop/played_scene.h"

namespace hapticd {

class SceneSlot {
 public:
  explicit SceneSlot(std::unique_ptr<PlayedScene> first) noexcept : playing_(std::move(first)) {
    HD_ASSERT(playing_ != nullptr);
  }

  [[nodiscard]] PlayedScene& playing() noexcept { return *playing_; }
  [[nodiscard]] const PlayedScene& playing() const noexcept { return *playing_; }

  /// `next` is to play after this one; `number`: of the command that brought it, 0: none. One after
  /// the other is the sender's rule.
  void wait(std::unique_ptr<PlayedScene> next, std::uint64_t number) noexcept {
    HD_ASSERT(next != nullptr && waiting_ == nullptr && retired_ == nullptr);
    waiting_ = std::move(next);
    number_ = number;
  }
  [[nodiscard]] bool waits() const noexcept { return waiting_ != nullptr; }

  /// The one that waits plays from here on.
  void swap() noexcept { retired_ = std::exchange(playing_, std::move(waiting_)); }
  /// Of the command that brought the one that plays since the last swap, once; 0: none.
  [[nodiscard]] std::uint64_t take_number() noexcept { return std::exchange(number_, 0); }

  /// True when one has played and is to be given back.
  [[nodiscard]] bool has_retired() const noexcept { return retired_ != nullptr; }
  [[nodiscard]] std::unique_ptr<PlayedScene> take_retired() noexcept { return std::move(retired_); }

 private:
  std::unique_ptr<PlayedScene> playing_;
  std::unique_ptr<PlayedScene> waiting_;
  std::unique_ptr<PlayedScene> retired_;
  std::uint64_t number_ = 0;  ///< of waiting_, then of what took its place
};

}  // namespace hapticd
