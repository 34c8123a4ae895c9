// Prints one hash per function over a fixed sweep of arguments. Equal output of two builds means
// equal bits of every result:
//   determinism_probe_core_math > a; <other build>/determinism_probe_core_math > b; cmp a b
#include <bit>
#include <cinttypes>
#include <cstdint>
#include <cstdio>

#include "core/math/elementary.h"
#include "core/math/pose.h"
#include "core/math/rotation.h"
#include "tests/support/pose_composition.h"
#include "tests/support/random.h"

namespace {

using namespace hapticd;

constexpr int kCount = 1'000'000;

/// FNV-1a over the bytes of numbers.
class Hash {
 public:
  void add(double number) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (unsigned shift = 0; shift < 64; shift += 8) {
      value_ = (value_ ^ ((bits >> shift) & 0xffU)) * 0x100000001b3U;
    }
  }
  void add(const Vector3& v) noexcept {
    for (const double number : {v.x(), v.y(), v.z()}) add(number);
  }
  void add(const Quaternion& q) noexcept {
    add(q.w());
    add(q.vec());
  }
  void print(const char* name) const { std::printf("%s %016" PRIx64 "\n", name, value_); }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

Vector3 random_vector(test::SplitMix64& random, double reach) {
  const double x = random.uniform(-reach, reach);
  const double y = random.uniform(-reach, reach);
  return {x, y, random.uniform(-reach, reach)};
}

void probe_elementary() {
  test::SplitMix64 random(1);
  Hash sin_cos_hash;
  Hash arctangent2_hash;
  Hash exponential_hash;
  Hash logarithm_hash;
  for (int i = 0; i < kCount; ++i) {
    const SinCos result = sin_cos(random.uniform(-1.0, 1.0) * (i % 2 == 0 ? 7.0 : 1e5));
    sin_cos_hash.add(result.sin);
    sin_cos_hash.add(result.cos);
    const double y = random.uniform(-1.0, 1.0);
    arctangent2_hash.add(arctangent2(y, random.uniform(-1.0, 1.0)));
    const double power = exponential(random.uniform(-750.0, 715.0));
    exponential_hash.add(power);
    exponential_hash.add(exponential(y));
    logarithm_hash.add(logarithm(power));
    logarithm_hash.add(logarithm(1.0 + y));
  }
  sin_cos_hash.print("sin_cos");
  arctangent2_hash.print("arctangent2");
  exponential_hash.print("exponential");
  logarithm_hash.print("logarithm");
}

void probe_rotation() {
  test::SplitMix64 random(2);
  Hash exp_hash;
  Hash log_hash;
  Hash log_near_hash;
  Hash pose_hash;
  Pose X_WG;
  for (int i = 0; i < kCount; ++i) {
    const Quaternion q = exp_rotation(random_vector(random, 4.0));
    exp_hash.add(q);
    log_hash.add(log_rotation(q));
    log_near_hash.add(log_rotation_near(q, random_vector(random, 4.0), 5.0));
    X_WG = compose(X_WG, inverse({q, random_vector(random, 0.1)}));
    X_WG.q = renormalised(X_WG.q);
    pose_hash.add(X_WG.q);
    pose_hash.add(X_WG.p);
  }
  exp_hash.print("exp_rotation");
  log_hash.print("log_rotation");
  log_near_hash.print("log_rotation_near");
  pose_hash.print("pose");
}

}  // namespace

int main() {
  probe_elementary();
  probe_rotation();
}
