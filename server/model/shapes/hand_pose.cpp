// See hand_pose.h. The measures are those of an average adult's hand, rounded; the angles were
// chosen by eye after pictures of the pose.
#include "server/model/shapes/hand_pose.h"

#include "core/math/elementary.h"

namespace hapticd {
namespace {

constexpr double kMm = 1e-3;
constexpr double kDegree = kPi / 180.0;

/// A finger as given: mm and degrees.
struct FingerPose {
  std::array<double, 3> knuckle;  ///< where it starts
  std::array<double, 3> forward;  ///< its direction when stretched, need not be unit
  std::array<double, 3> back;     ///< out of its back, need not be orthogonal
  std::array<double, 3> lengths;  ///< of the three bones, the last to the end of the pad
  std::array<double, 3> bends;    ///< at the start of each bone, positive towards the palm
  std::array<double, 3> radii;    ///< at the three joints
  std::array<double, 3> pad;      ///< semi-axes across, up, along
};

constexpr std::array<FingerPose, kFingers> kPoses{{
    // Thumb: its first bone is part of the palm's ball.
    {{-34, -14, -42},
     {-0.42, -0.18, -1},
     {-0.75, 0.65, 0},
     {28, 29, 27},
     {0, -6, 14},
     {12, 10.5, 9.2},
     {8.6, 7.0, 12.5}},
    {{-28, 4, -86},
     {-0.08, 0, -1},
     {0, 1, 0},
     {45, 26, 23.5},
     {22, 17, 9},
     {9.2, 8.3, 7.3},
     {7.2, 6.2, 11.0}},
    {{-6, 7, -90},
     {0.0, 0, -1},
     {0, 1, 0},
     {49, 30, 24},
     {-10, 62, 34},
     {9.3, 8.5, 7.5},
     {7.4, 6.4, 11.0}},
    {{15, 5, -85},
     {0.1, 0, -1},
     {0, 1, 0},
     {45, 28, 24},
     {-10, 60, 34},
     {8.8, 8.0, 7.1},
     {7.0, 6.1, 11.0}},
    {{33, 0, -75},
     {0.24, 0, -1},
     {0, 1, 0},
     {36, 21, 21},
     {-8, 52, 30},
     {7.9, 7.0, 6.2},
     {6.1, 5.3, 9.8}},
}};

/// Where the last bone's round cone ends: this far behind the pad's centre and this much thinner
/// than the pad, mm, so that it stays inside.
constexpr double kBoneBehindPad = 2.0;
constexpr double kBoneInsidePad = 1.1;

Vector3 mm(const std::array<double, 3>& a) { return {a[0] * kMm, a[1] * kMm, a[2] * kMm}; }

FingerBones bones(const FingerPose& pose) {
  FingerBones finger;
  Vector3 along = unit_or_zero(to_vector(pose.forward));
  Vector3 back = to_vector(pose.back);
  back = unit_or_zero(back - dot(back, along) * along);
  Vector3 p = mm(pose.knuckle);
  for (std::size_t i = 0; i < 3; ++i) {
    const SinCos bend = sin_cos(pose.bends[i] * kDegree);
    const Vector3 old_along = along;
    along = bend.cos * along - bend.sin * back;
    back = bend.cos * back + bend.sin * old_along;
    RoundCone cone{p, p, pose.radii[i] * kMm, 0.0};
    if (i < 2) {
      p += along * (pose.lengths[i] * kMm);
      cone.r_b = pose.radii[i + 1] * kMm;
      cone.p_b = p;
    } else {
      finger.pad.semi_axes = mm(pose.pad);
      finger.pad.p_G = p + along * ((pose.lengths[i] - pose.pad[2]) * kMm);
      cone.p_b = finger.pad.p_G - along * (kBoneBehindPad * kMm);
      cone.r_b = (pose.pad[1] - kBoneInsidePad) * kMm;
    }
    finger.cones.push_back(cone);
  }
  finger.pad.R_G.col(0) = back.cross(along);
  finger.pad.R_G.col(1) = back;
  finger.pad.R_G.col(2) = along;
  return finger;
}

RoundCone cone_mm(const std::array<double, 3>& a, double r_a, const std::array<double, 3>& b,
                  double r_b) {
  return {mm(a), mm(b), r_a * kMm, r_b * kMm};
}

}  // namespace

HandBones hand_bones() {
  HandBones hand;
  // Wrist, the bones behind the four knuckles, the balls of thumb and little finger.
  hand.palm = {cone_mm({-9, 1, 0}, 14, {-11, 1, -18}, 12.5),
               cone_mm({9, 1, 0}, 14, {11, 0, -18}, 12.5),
               cone_mm({-11, 0, -16}, 12.5, {-28, 4, -86}, 10.2),
               cone_mm({-4, 2, -14}, 12.5, {-6, 7, -90}, 10.4),
               cone_mm({6, 1, -14}, 12.5, {15, 5, -85}, 9.8),
               cone_mm({13, -1, -16}, 12, {33, 0, -75}, 8.8),
               cone_mm({-15, -6, -18}, 13, {-34, -14, -42}, 12),
               cone_mm({16, -6, -20}, 11.5, {27, -5, -60}, 9.5)};
  for (std::size_t i = 0; i < kPoses.size(); ++i) hand.fingers[i] = bones(kPoses[i]);
  return hand;
}

}  // namespace hapticd
