// The States of one tick as bytes, for all its subscribers: filled in once for equal subscriptions,
// cut to size and encoded once for equal subscriptions with equal room. Pure. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/network/server_host.h"

namespace hapticd {

/// A State as it leaves.
struct EncodedState {
  std::vector<std::string> parts;  ///< one, or as many as its tools need
  std::uint64_t unfit = 0;         ///< parts that no datagram holds; they are not in `parts`
  /// Index of the first string with a StringState.sounding that had no room here.
  std::optional<std::uint32_t> soundings_from = std::nullopt;
};

/// The States of the tick that begin() named.
class EncodedStates {
 public:
  /// Fills in what a subscription asks for.
  using Fill = std::function<void(const Subscription&, v1::State&)>;

  /// Another tick; what was encoded for the one before is forgotten.
  void begin(std::uint64_t tick, std::uint32_t scene_id) {
    tick_ = tick;
    scene_id_ = scene_id;
    used_ = 0;
  }

  /// The State for `subscription` in parts of at most `room` bytes. `fill` is called when this tick
  /// has not been filled in for an equal subscription. rest_radii_m: see fit_state(). Where all of
  /// it has room, and nobody holds what was got for earlier ticks, the heap is left alone.
  std::shared_ptr<const EncodedState> get(const Subscription& subscription, std::size_t room,
                                          const Fill& fill, std::span<const double> rest_radii_m);

 private:
  struct Fitted {
    std::size_t room = 0;
    std::shared_ptr<const EncodedState> encoded;
  };
  struct Filled {
    Subscription subscription;
    v1::State state;
    std::size_t bytes = 0;
    std::shared_ptr<EncodedState> whole;  ///< written over in a later tick when nobody else has it
    bool is_whole = false;                ///< `whole` is of this tick: somebody had room for it
    std::vector<Fitted> fitted;
  };

  Filled& filled(const Subscription& subscription, const Fill& fill);
  static void write_whole(Filled& filled);

  std::uint64_t tick_ = 0;
  std::uint32_t scene_id_ = 0;
  std::vector<Filled> all_;  ///< the first `used_` are of this tick; the others keep their memory
  std::size_t used_ = 0;
};

}  // namespace hapticd
