// A deterministic session of contact ticks for the tests of the realtime promise and for comparing
// builds: a tool pressed, dragged and torn over seven strings and a body, with glitches of the
// device and scenes that overlap the tool. No libm.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/simulation/tool_renderer.h"
#include "core/tree/sphere_tree.h"
#include "tests/support/guarded_step.h"

namespace hapticd::test {

class ContactSession {
 public:
  enum class Tool : std::uint8_t { kHand, kBlob };

  explicit ContactSession(Tool tool);

  /// Runs `ticks` more ticks. Allocates nothing.
  void run(std::int64_t ticks) noexcept;

  /// FNV-1a over the bits of every wrench and graphic pose so far.
  [[nodiscard]] std::uint64_t hash() const noexcept { return hash_; }
  /// Ticks that ended with a contact force.
  [[nodiscard]] std::int64_t contact_ticks() const noexcept { return contact_ticks_; }
  /// Ticks with a latched pose fault.
  [[nodiscard]] std::int64_t faults() const noexcept { return faults_; }
  /// Ticks spent pushing the tool out of an overlap.
  [[nodiscard]] std::int64_t recoveries() const noexcept { return recoveries_; }

 private:
  [[nodiscard]] HandPose sample() const noexcept;
  void add_to_hash(const RenderedTool& tick) noexcept;

  SphereTree tool_;
  SphereTree body_;
  std::vector<Capsule> strings_;
  Capsule rest_;  ///< the middle string where it belongs
  std::vector<BodyView> bodies_;
  double touch_height_;
  ToolScene scene_;
  ToolState state_;
  GuardedHand hand_;
  std::unique_ptr<ContactProblem> problem_ = std::make_unique<ContactProblem>();
  std::int64_t tick_ = 0;
  std::uint64_t hash_ = 0xcbf29ce484222325U;
  std::int64_t contact_ticks_ = 0;
  std::int64_t faults_ = 0;
  std::int64_t recoveries_ = 0;
};

}  // namespace hapticd::test
