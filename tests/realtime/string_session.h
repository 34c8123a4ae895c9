// A deterministic session of the whole tick for the tests of the realtime promise and for comparing
// builds: a finger and a hand that press, pluck, sweep and slide over seven strings, with repeated
// and bad samples and uneven ticks. No libm.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/scene/owned_simulation.h"
#include "core/tree/sphere_tree.h"
#include "tests/support/guarded_step.h"

namespace hapticd::test {

class StringSession {
 public:
  enum class Play : std::uint8_t {
    kPaper,       ///< rigid strings, the fundamental, a finger
    kDeflecting,  ///< strings that yield, a hand
    kModes,       ///< the same with modes, friction, lateral force and glide, a finger
  };

  explicit StringSession(Play play);

  /// Runs `ticks` more ticks. Allocates nothing.
  void run(std::int64_t ticks) noexcept;

  /// FNV-1a over the bits of every wrench, graphic pose, reading and event so far.
  [[nodiscard]] std::uint64_t hash() const noexcept { return hash_; }
  /// Ticks that ended with a force.
  [[nodiscard]] std::int64_t contact_ticks() const noexcept { return contact_ticks_; }
  /// Ticks in which a vibration struck the tool.
  [[nodiscard]] std::int64_t struck_ticks() const noexcept { return struck_ticks_; }
  [[nodiscard]] std::int64_t tones() const noexcept { return tones_; }
  /// Ticks with a latched pose fault.
  [[nodiscard]] std::int64_t faults() const noexcept { return faults_; }

 private:
  [[nodiscard]] HandPose sample() noexcept;
  void add_to_hash(const SimulationTick& output) noexcept;
  void add(double number) noexcept;

  SphereTree tool_;
  std::vector<Capsule> capsules_;
  std::vector<StringConstants> strings_;
  OwnedSimulation play_;
  GuardedHand hand_;
  SimulationTick output_;
  double touch_height_;
  std::int64_t tick_ = 0;
  std::int64_t t_ns_ = 0;
  std::uint64_t hash_ = 0xcbf29ce484222325U;
  std::int64_t contact_ticks_ = 0;
  std::int64_t struck_ticks_ = 0;
  std::int64_t tones_ = 0;
  std::int64_t faults_ = 0;
};

}  // namespace hapticd::test
