// What the motors give: the command in force, evaluated on the newest measurement and clamped, in
// whole numbers throughout; see hapticd_device.h. The largest intermediate values stand beside the
// sums: none exceeds 63 bits.
#include <string.h>

#include "hapticd_device.h"

enum { kMicroPerCenti = 10000, kMicroPerMilli = 1000 };

/// Rows of the symmetric K in its six entries.
static const uint8_t kRow[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

/// Added to the diagonal of K before it is judged, N/m: its entries are rounded to half a newton
/// per metre each, three of them to a row, and the host reckons with more than whole numbers. Less:
/// a host's spring along one direction may be refused; more: K may push along a way by so much.
enum { kRoundedNpm = 2 };

/// K pushes along no way: of K with kRoundedNpm more no principal minor is below zero. All of
/// them count, since a minor that is zero says nothing of the larger ones. Below 2^49.
static bool gives_nothing(const int16_t k_npm[6]) {
  const int64_t xx = (int64_t)k_npm[0] + kRoundedNpm;
  const int64_t yy = (int64_t)k_npm[1] + kRoundedNpm;
  const int64_t zz = (int64_t)k_npm[2] + kRoundedNpm;
  const int64_t xy = k_npm[3], xz = k_npm[4], yz = k_npm[5];
  if (xx < 0 || yy < 0 || zz < 0) return false;
  if (xx * yy < xy * xy || xx * zz < xz * xz || yy * zz < yz * yz) return false;
  return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz) >= 0;
}

bool hap_affine_is_sound(const HapDevice* device, const HapAffine* affine) {
  const HapSettings* most = &device->settings;
  for (int row = 0; row < 3; ++row) {
    if (affine->k_npm[row] < 0) return false;
    if (affine->b_mnspm[row] > most->affine_b_max_mnspm) return false;
    if (affine->kr_mnmprad[row] > most->affine_kr_max_mnmprad) return false;
    if (affine->br_10unmsprad[row] > most->affine_br_max_10unmsprad) return false;
    int32_t sum = 0;
    for (int column = 0; column < 3; ++column) {
      const int32_t entry = affine->k_npm[kRow[row][column]];
      sum += entry < 0 ? -entry : entry;
    }
    if ((uint32_t)sum > most->affine_k_max_npm) return false;
  }
  return gives_nothing(affine->k_npm);
}

/// Whole part of the square root, rounded up: a norm is never taken for smaller than it is.
static int64_t root_up(uint64_t square) {
  uint64_t root = 0;
  for (uint64_t bit = (uint64_t)UINT32_MAX + 1; bit != 0; bit >>= 1) {
    const uint64_t next = root | bit;
    // next * next needs next < 2^32.
    if (next <= UINT32_MAX && next * next <= square) root = next;
  }
  return (int64_t)(root * root < square ? root + 1 : root);
}

/// Shortens `v` to at most `most` >= 0 along its direction; whether it had to. |v| < 2^62.
static bool clamp(int64_t v[3], int64_t most) {
  // Halved until the squares fit; the direction stays, and the length is cut anyway: most < 2^30.
  for (int i = 0; i < 3; ++i) {
    while (v[i] > INT32_MAX || v[i] < -INT32_MAX) {
      for (int k = 0; k < 3; ++k) v[k] /= 2;
    }
  }
  uint64_t square = 0;  // <= 3 * 2^62
  for (int i = 0; i < 3; ++i) square += (uint64_t)(v[i] * v[i]);
  if (square <= (uint64_t)(most * most)) return false;
  const int64_t length = root_up(square);
  for (int i = 0; i < 3; ++i) v[i] = v[i] * most / length;  // < 2^31 * 2^30
  return true;
}

/// Rotation from where the handle is to where it was, in D: 2 sign(w) vec(q_ref conj(q)), Q30 rad.
static void turn_back(const int32_t a[4], const int32_t b[4], int64_t turn[3]) {
  const int64_t w0 = a[0], x0 = a[1], y0 = a[2], z0 = a[3];
  const int64_t w1 = b[0], x1 = -(int64_t)b[1], y1 = -(int64_t)b[2], z1 = -(int64_t)b[3];
  // Products of 30 bits each; >> 30 by division, for the sign.
  const int64_t unit = (int64_t)1 << 30;
  const int64_t w = (w0 * w1 - x0 * x1 - y0 * y1 - z0 * z1) / unit;
  const int64_t sign = w < 0 ? -2 : 2;
  turn[0] = sign * ((w0 * x1 + x0 * w1 + y0 * z1 - z0 * y1) / unit);
  turn[1] = sign * ((w0 * y1 - x0 * z1 + y0 * w1 + z0 * x1) / unit);
  turn[2] = sign * ((w0 * z1 + x0 * y1 - y0 * x1 + z0 * w1) / unit);
}

static void add_gains(const HapDevice* device, int64_t force[3], int64_t torque[3]) {
  const HapAffine* gains = &device->command;
  const HapMeasurement* now = &device->now;
  int64_t turn[3];
  turn_back(device->reference.quat_q30, now->quat_q30, turn);
  for (int i = 0; i < 3; ++i) {
    int64_t spring = 0;  // N/m nm = nN, <= 3 * 2^15 * 2^32
    for (int k = 0; k < 3; ++k) {
      const int64_t back = (int64_t)device->reference.pos_nm[k] - now->pos_nm[k];
      spring += gains->k_npm[kRow[i][k]] * back;
    }
    force[i] += spring / 1000;
    force[i] -= (int64_t)gains->b_mnspm[i] * now->vel[i] / 10;
    // mN m Q30 -> uN m: 2^16 * 2^34 * 2^10.
    torque[i] += gains->kr_mnmprad[i] * turn[i] * kMicroPerMilli / ((int64_t)1 << 30);
    torque[i] -= (int64_t)gains->br_10unmsprad[i] * now->avel[i] / 100;
  }
}

void hap_evaluate(HapDevice* device, HapOutput* output) {
  memset(output, 0, sizeof *output);
  if (!device->enabled) return;
  const HapCapabilities* caps = &device->settings.capabilities;
  const HapAffine* command = &device->command;
  output->motors_on = true;
  output->brake = (command->base.flags & kHapBrake) != 0 && (caps->caps & kHapHasBrake) != 0;
  device->saturated = device->active = false;
  if ((command->base.flags & kHapBrake) != 0) return;
  output->gravity = device->config.grav_comp != 0;

  int64_t force[3];
  int64_t torque[3];
  for (int i = 0; i < 3; ++i) {
    force[i] = command->base.force_un[i];
    torque[i] = command->base.torque_unm[i];
  }
  if (command->base.id == kHapAffineId) add_gains(device, force, torque);
  for (int i = 0; i < 3; ++i) {
    if ((caps->dof >> (6 + i) & 1) == 0) force[i] = 0;
    if ((caps->dof >> (9 + i) & 1) == 0) torque[i] = 0;
  }
  device->saturated = clamp(force, (int64_t)device->config.f_cap_cn * kMicroPerCenti);
  device->saturated |= clamp(torque, (int64_t)device->config.tau_cap_mnm * kMicroPerMilli);
  for (int i = 0; i < 3; ++i) {
    output->force_un[i] = (int32_t)force[i];
    output->torque_unm[i] = (int32_t)torque[i];
    device->active |= force[i] != 0 || torque[i] != 0;
  }
  if ((command->base.flags & kHapGrip) == 0 || (caps->dof >> 13 & 1) == 0) return;
  const int32_t most =
      device->settings.grip_peak_mn < INT16_MAX ? device->settings.grip_peak_mn : INT16_MAX;
  int32_t grip = command->base.grip_mn;
  if (grip > most || grip < -most) {
    device->saturated = true;
    grip = grip > 0 ? most : -most;
  }
  output->grip_mn = (int16_t)grip;
  device->active |= grip != 0;
}
