// The rival of the tree queries: every pair, structure of arrays, four pairs at a time in AVX2, the
// same results (contacts below the margin, the true minimum gap). A good programmer's exhaustive
// loop: squares are compared with the square of the radius in force, so roots are taken only of
// pairs that count. Needs a CPU with AVX2.
#pragma once

#include <vector>

#include "core/collision/query.h"

namespace hapticd::test {

/// Room for the tool's centres in another frame; sized once.
class Avx2BruteForce {
 public:
  explicit Avx2BruteForce(const SphereTreeView& tool);

  /// As find_contacts with leaf-level options; contacts beyond the capacity are dropped.
  void find(const Pose& X_WG, const ObstaclesView& obstacles, const QueryOptions& options,
            ContactSet& out);

 private:
  void against_capsule(const Pose& X_WG, const ObstaclesView& obstacles, std::int32_t capsule,
                       double margin, ContactSet& out);
  void against_body(const Pose& X_WG, const ObstaclesView& obstacles, std::int32_t body,
                    double margin, ContactSet& out);
  void add(const ContactKey& key, const Pose& X_WG, const ObstaclesView& obstacles, double margin,
           ContactSet& out);

  SphereTreeView tool_;
};

}  // namespace hapticd::test
