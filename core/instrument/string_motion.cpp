// Exact rotation of modes by sub-steps. Sums run in four lanes in a fixed order, so that their bits
// are the same on every processor. The loops of a sub-step are plain bodies that are inlined into a
// baseline and an AVX2 function.
#include "core/instrument/string_motion.h"

#include <algorithm>
#include <cmath>

#include "core/instrument/mode_series.h"
#include "core/math/cpu.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Four modes that are computed together; a processor of two lanes does so in halves.
using Four [[gnu::vector_size(32), gnu::may_alias]] = double;
constexpr std::size_t kLanes = 4;
/// Sub-steps of the fastest mode's period, at least.
constexpr double kStepsPerPeriod = 4.0;
/// sigma / omega, at most: beyond it a mode no longer swings.
constexpr double kMostDamped = 0.99;

std::size_t size(const ModeTable& table) noexcept { return static_cast<std::size_t>(table.count); }

[[gnu::always_inline]] inline std::size_t fours(const ModeTable& table) noexcept {
  return static_cast<std::size_t>(table.count) / kLanes;
}
[[gnu::always_inline]] inline const Four* in_fours(const PerMode& numbers) noexcept {
  return reinterpret_cast<const Four*>(numbers.data());
}
[[gnu::always_inline]] inline Four* in_fours(PerMode& numbers) noexcept {
  return reinterpret_cast<Four*>(numbers.data());
}

/// Sum of the lanes, in pairs.
[[gnu::always_inline]] inline double sum_of(const Four& four) noexcept {
  return (four[0] + four[1]) + (four[2] + four[3]);
}

[[gnu::always_inline]] inline Transverse displacement_body(const ModeTable& table,
                                                           const ModalMotion& motion,
                                                           const PerMode& shapes) noexcept {
  const Four* const phi = in_fours(shapes);
  const Four* const qy = in_fours(motion.qy);
  const Four* const qz = in_fours(motion.qz);
  Four y{};
  Four z{};
  for (std::size_t i = 0; i < fours(table); ++i) {
    y += phi[i] * qy[i];
    z += phi[i] * qz[i];
  }
  return {sum_of(y), sum_of(z)};
}

[[gnu::always_inline]] inline PlaceOfString slide_body(const ModeTable& table,
                                                       const ModalMotion& motion,
                                                       const PerMode& step,
                                                       PerMode& shapes) noexcept {
  const Four* const qy = in_fours(motion.qy);
  const Four* const qz = in_fours(motion.qz);
  const Four* const push_q = in_fours(table.push_q);
  Four y{};
  Four z{};
  Four response{};
  for (std::size_t i = 0; i < fours(table); ++i) {
    const Four phi = in_fours(shapes)[i] + in_fours(step)[i];
    in_fours(shapes)[i] = phi;
    y += phi * qy[i];
    z += phi * qz[i];
    response += phi * phi * push_q[i];
  }
  return {{sum_of(y), sum_of(z)}, sum_of(response)};
}

[[gnu::always_inline]] inline Transverse turn_body(const ModeTable& table, const PerMode& shapes,
                                                   ModalMotion& motion) noexcept {
  const Four* const qq = in_fours(table.qq);
  const Four* const qv = in_fours(table.qv);
  const Four* const vv = in_fours(table.vv);
  const Four* const phi = in_fours(shapes);
  Four sum_y{};
  Four sum_z{};
  for (std::size_t i = 0; i < fours(table); ++i) {
    Four& qy = in_fours(motion.qy)[i];
    Four& vy = in_fours(motion.vy)[i];
    Four& qz = in_fours(motion.qz)[i];
    Four& vz = in_fours(motion.vz)[i];
    const Four y = qq[i] * qy + qv[i] * vy;
    const Four z = qq[i] * qz + qv[i] * vz;
    vy = vv[i] * vy - qv[i] * qy;
    vz = vv[i] * vz - qv[i] * qz;
    qy = y;
    qz = z;
    sum_y += phi[i] * y;
    sum_z += phi[i] * z;
  }
  return {sum_of(sum_y), sum_of(sum_z)};
}

[[gnu::always_inline]] inline void push_body(const ModeTable& table, const PerMode& shapes,
                                             const Transverse& force,
                                             ModalMotion& motion) noexcept {
  const Four* const phi = in_fours(shapes);
  const Four* const push_q = in_fours(table.push_q);
  const Four* const push_v = in_fours(table.push_v);
  for (std::size_t i = 0; i < fours(table); ++i) {
    const Four q = push_q[i] * phi[i];
    const Four v = push_v[i] * phi[i];
    in_fours(motion.qy)[i] += q * force.y;
    in_fours(motion.vy)[i] += v * force.y;
    in_fours(motion.qz)[i] += q * force.z;
    in_fours(motion.vz)[i] += v * force.z;
  }
}

[[gnu::target("avx2")]] Transverse displacement_avx2(const ModeTable& table,
                                                     const ModalMotion& motion,
                                                     const PerMode& shapes) noexcept {
  return displacement_body(table, motion, shapes);
}

[[gnu::target("avx2")]] PlaceOfString slide_avx2(const ModeTable& table, const ModalMotion& motion,
                                                 const PerMode& step, PerMode& shapes) noexcept {
  return slide_body(table, motion, step, shapes);
}

[[gnu::target("avx2")]] Transverse turn_avx2(const ModeTable& table, const PerMode& shapes,
                                             ModalMotion& motion) noexcept {
  return turn_body(table, shapes, motion);
}

[[gnu::target("avx2")]] void push_avx2(const ModeTable& table, const PerMode& shapes,
                                       const Transverse& force, ModalMotion& motion) noexcept {
  push_body(table, shapes, force, motion);
}

/// What a mode is turned by, as in ModeTable.
struct Turn {
  double qq, qv, vv;
};

/// Over `time`, s; turns are reduced before they become an angle.
Turn turn_over(double omega, double sigma, double time) noexcept {
  const double r = std::min(sigma / omega, kMostDamped);
  const double w = std::sqrt(1.0 - r * r);
  const double turns = omega * w * time / (2.0 * kPi);
  const double fall = exponential(-sigma * time);
  const SinCos turned = sin_cos(2.0 * kPi * (turns - nearest_integer(turns)));
  const double c = fall * turned.cos;
  const double s = fall * turned.sin / w;
  return {c + r * s, s, c - r * s};
}

void fill(std::size_t i, const StringConstants& string, double sigma, ModeTable& table) noexcept {
  const double frequency = mode_series(string).frequency(static_cast<int>(i) + 1);
  const double omega = 2.0 * kPi * frequency;
  const double stiffness = modal_stiffness(string, frequency);
  const Turn turn = turn_over(omega, sigma, table.step);
  table.stiffness[i] = stiffness;
  table.omega[i] = omega;
  table.sigma[i] = sigma;
  table.qq[i] = turn.qq;
  table.qv[i] = turn.qv;
  table.vv[i] = turn.vv;
  table.push_q[i] = (1.0 - turn.qq) / stiffness;
  table.push_v[i] = turn.qv / stiffness;
}

}  // namespace

ModeTable mode_table(const StringConstants& string, const StringLoss& loss, int modes,
                     int substeps) noexcept {
  ModeTable table;
  table.step = 1e-3 / substeps;
  if (!(string.frequency > 0.0)) return table;
  const double fitting = 1.0 / (kStepsPerPeriod * table.step * string.frequency);
  const double most = std::min(static_cast<double>(std::min(modes, kMaxModes)), fitting);
  table.count = 4 * static_cast<int>(most / 4.0);
  for (std::size_t i = 0; i < size(table); ++i) {
    const auto n = static_cast<double>(i + 1);
    fill(i, string, 1.0 / loss.decay + n * n * loss.loss_n2, table);
  }
  return table;
}

void mode_shapes(const ModeTable& table, double lambda, PerMode& shapes) noexcept {
  // From the nearer end, where shapes are small; mirrored, even modes change their sign.
  const bool mirrored = lambda > 0.5;
  const SinCos first = sin_cos(kPi * (mirrored ? 1.0 - lambda : lambda));
  double before = 0.0;
  double now = first.sin;
  for (std::size_t i = 0; i < size(table); ++i) {
    shapes[i] = mirrored && i % 2 == 1 ? -now : now;
    const double next = 2.0 * first.cos * now - before;
    before = now;
    now = next;
  }
}

Transverse displacement(const ModeTable& table, const ModalMotion& motion,
                        const PerMode& shapes) noexcept {
  return avx2_available() ? displacement_avx2(table, motion, shapes)
                          : displacement_body(table, motion, shapes);
}

double response(const ModeTable& table, const PerMode& from, const PerMode& to) noexcept {
  Four sum{};
  for (std::size_t i = 0; i < fours(table); ++i) {
    sum += in_fours(from)[i] * in_fours(to)[i] * in_fours(table.push_q)[i];
  }
  return sum_of(sum);
}

PlaceOfString slide(const ModeTable& table, const ModalMotion& motion, const PerMode& step,
                    PerMode& shapes) noexcept {
  return avx2_available() ? slide_avx2(table, motion, step, shapes)
                          : slide_body(table, motion, step, shapes);
}

Transverse turn(const ModeTable& table, const PerMode& shapes, ModalMotion& motion) noexcept {
  return avx2_available() ? turn_avx2(table, shapes, motion) : turn_body(table, shapes, motion);
}

void turn_on(const ModeTable& table, std::int64_t steps, ModalMotion& motion) noexcept {
  const double time = table.step * static_cast<double>(steps);
  for (std::size_t i = 0; i < size(table); ++i) {
    const Turn by = turn_over(table.omega[i], table.sigma[i], time);
    const auto plane = [&](double& q, double& v) {
      const double turned = by.qq * q + by.qv * v;
      v = by.vv * v - by.qv * q;
      q = turned;
    };
    plane(motion.qy[i], motion.vy[i]);
    plane(motion.qz[i], motion.vz[i]);
  }
}

void push(const ModeTable& table, const PerMode& shapes, const Transverse& force,
          ModalMotion& motion) noexcept {
  if (avx2_available()) {
    push_avx2(table, shapes, force, motion);
  } else {
    push_body(table, shapes, force, motion);
  }
}

double energy(const ModeTable& table, const ModalMotion& motion) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(table); ++i) {
    sum += 0.5 * table.stiffness[i] *
           ((motion.qy[i] * motion.qy[i] + motion.vy[i] * motion.vy[i]) +
            (motion.qz[i] * motion.qz[i] + motion.vz[i] * motion.vz[i]));
  }
  return sum;
}

double residual_compliance(const StringConstants& string, const ModeTable& table, double lambda,
                           const PerMode& shapes) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(table); ++i) sum += shapes[i] * shapes[i] / table.stiffness[i];
  return std::max(0.0, lambda * (1.0 - lambda) * string.length / string.tension - sum);
}

}  // namespace hapticd
