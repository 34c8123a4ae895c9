// Watches the force of the whole tick: it may change as fast as the hand presses and as a string
// swings, and where a string slips off it must be what the exact statics leaves. What swings is
// not asked of the product: the amplitude follows from the hand's way and the string's law. SI,
// strings of an Instrument. Not RT.
#pragma once

#include <vector>

#include "tests/core/simulation/simulation_fixture.h"
#include "tests/truth/exact_statics.h"

namespace hapticd::test {

/// How far a string can swing for how a hand has touched it: by the largest delta of every touch,
/// from Eq. 10 to 12 in series with the coupling, less the free decay.
class SwingBound {
 public:
  explicit SwingBound(const StringParameters& string);
  /// The finger's centre goes straight from `from` to `to` in `dt` s.
  void look(const Vector3& from, const Vector3& to, double dt);
  /// Most that the string swings now, m.
  [[nodiscard]] double amplitude() const noexcept { return ringing_; }

 private:
  StringParameters string_;
  double delta_ = 0.0;
  double largest_ = 0.0;
  double ringing_ = 0.0;

  void sample(const Vector3& p, double dt);
};

/// What an exact string without vibration does to a finger that the hand holds at `p_WH`.
struct StaticPress {
  Vector3 f_H_W{0.0, 0.0, 0.0};  ///< N
  double energy = 0.0;           ///< of string and coupling, J: the force is its slope
  double delta = 0.0;            ///< m
};

[[nodiscard]] StaticPress static_press(const StringParameters& string, const Vector3& p_WH);

class ForceWatch {
 public:
  /// `preset` is what `guqin` was made of.
  ForceWatch(Instrument& guqin, const Preset& preset);

  /// Call after each tick: the change of the force over what is allowed; where a string is lost,
  /// how far the force is from that of the exact statics over the same.
  double look();
  /// Ticks in which a string was lost.
  [[nodiscard]] int lost() const noexcept { return lost_; }

 private:
  [[nodiscard]] double swing(std::size_t string);
  /// Force on the hand at the exact rest downhill of the place before this tick.
  [[nodiscard]] Vector3 exact_force() const;
  [[nodiscard]] StaticPlace place() const;
  bool lost_one();

  Instrument& guqin_;
  Preset preset_;
  StaticScene scene_;
  std::vector<Sphere> tool_;
  std::vector<StaticString> yielding_;
  std::vector<Capsule> rigid_;
  std::vector<SwingBound> swings_;
  StaticPlace place_;
  Vector3 p_;
  Vector3 f_{0.0, 0.0, 0.0};
  std::vector<std::int32_t> pressed_;
  int lost_ = 0;
};

}  // namespace hapticd::test
