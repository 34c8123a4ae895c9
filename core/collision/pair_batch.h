// Many pairs with one body, or one leg of a string, evaluated together: arrays, so that the
// compiler computes several at once, each with the operations of core/collision/primitive_gap.h in
// their order, hence the same bits. RT: yes; about 5 ns per gap, 10 per contact.
#pragma once

#include <array>
#include <cstddef>

#include "core/collision/primitive_gap.h"
#include "core/math/realtime.h"

namespace hapticd {

/// Pairs of tool spheres with one obstacle.
class PairBatch {
 public:
  static constexpr std::size_t kCapacity = 64;

  explicit PairBatch(const ToolPlacement& tool) noexcept : tool_(tool) {}

  /// Empties; the pairs to come are with spheres of this body.
  void begin(const Pose& X_WB) noexcept {
    count_ = 0;
    of_body_ = true;
    body_ = place_body(X_WB, tool_);
  }
  /// Empties; the pairs to come are with this capsule.
  void begin(const AxisSegment& segment) noexcept {
    count_ = 0;
    of_body_ = false;
    segment_ = segment;
  }

  [[nodiscard]] bool full() const noexcept { return count_ == kCapacity; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }

  /// Adds a tool sphere against the capsule. The batch must not be full.
  void add(const Sphere& sphere_G) noexcept {
    p_GC_.set(count_, sphere_G.p);
    r_tool_[count_++] = sphere_G.r;
  }
  /// Adds a tool sphere against a sphere of the body.
  void add(const Sphere& sphere_G, const Sphere& sphere_B) noexcept {
    p_B_.set(count_, sphere_B.p);
    r_body_[count_] = sphere_B.r;
    add(sphere_G);
  }

  /// Centre of a tool sphere in the frame of the body that the pairs are with, m.
  [[nodiscard]] Vector3 in_body(const Sphere& sphere_G) const noexcept {
    return to_body(body_, sphere_G.p);
  }

  /// Evaluates the gaps of all.
  HD_REALTIME void find_gaps() noexcept;
  /// Evaluates normals and contact points of all, after find_gaps().
  HD_REALTIME void find_contacts() noexcept;

  /// Signed distance of pair `j`, m.
  [[nodiscard]] double gap(std::size_t j) const noexcept { return gap_[j]; }
  /// Gives `contact`, of pair `j`, its new place; its key stays.
  void write(std::size_t j, Contact& contact) const noexcept {
    if (distance_[j] < kMinLength) [[unlikely]] {
      contact = concentric(j, contact.key);
      return;
    }
    contact.nhat_OG_W = nhat_.at(j);
    contact.p_WC = p_WC_.at(j);
    contact.gap = gap_[j];
    contact.lambda = lambda_[j];
  }

 private:
  using Numbers = std::array<double, kCapacity>;
  struct Points {
    Numbers x, y, z;

    void set(std::size_t j, const Vector3& p) noexcept {
      x[j] = p.x();
      y[j] = p.y();
      z[j] = p.z();
    }
    [[nodiscard]] Vector3 at(std::size_t j) const noexcept { return {x[j], y[j], z[j]}; }
  };

  /// The loops go over whole vectors: what is left over repeats the last pair.
  static constexpr std::size_t kLanes = 4;
  [[nodiscard]] std::size_t whole_lanes() const noexcept {
    return (count_ + kLanes - 1) / kLanes * kLanes;
  }
  void repeat(std::size_t from, std::size_t to) noexcept {
    p_GC_.set(to, p_GC_.at(from));
    r_tool_[to] = r_tool_[from];
    if (!of_body_) return;
    p_B_.set(to, p_B_.at(from));
    r_body_[to] = r_body_[from];
  }

  void find_body_gaps() noexcept;
  void find_capsule_gaps() noexcept;
  void turn_to_world() noexcept;
  /// The contact of a centre on the obstacle's axis or in its centre.
  [[nodiscard]] Contact concentric(std::size_t j, const ContactKey& key) const noexcept;

  ToolPlacement tool_;
  bool of_body_ = false;
  PlacedBody body_;
  AxisSegment segment_;
  std::size_t count_ = 0;
  Points p_GC_;    ///< axes of G, m
  Points p_B_;     ///< m
  Points offset_;  ///< PrimitiveGap::offset, m
  Points nhat_;    ///< in W
  Points p_WC_;    ///< m
  Numbers r_tool_, r_body_, distance_, gap_, lambda_;
};

}  // namespace hapticd
