// Exhaustive search as anyone would write it: arrays of coordinates, one plain loop over all pairs
// that takes the root and subtracts the radii, left to the compiler to vectorise. The same results
// as the tree queries.
#pragma once

#include <vector>

#include "core/collision/query.h"

namespace hapticd::test {

/// Room for the gaps of one loop; sized once.
class PlainBruteForce {
 public:
  explicit PlainBruteForce(const SphereTreeView& tool) : tool_(tool) {}

  /// As find_contacts with leaf-level options; contacts beyond the capacity are dropped.
  void find(const Pose& X_WG, const ObstaclesView& obstacles, const QueryOptions& options,
            ContactSet& out);

 private:
  void against_capsule(const Pose& X_WG, const ObstaclesView& obstacles, std::int32_t capsule,
                       ContactSet& out);
  void against_body(const Pose& X_WG, const ObstaclesView& obstacles, std::int32_t body,
                    ContactSet& out);
  void take(const ContactKey& key, const Pose& X_WG, const ObstaclesView& obstacles,
            ContactSet& out);

  SphereTreeView tool_;
  std::vector<double> gap_;
};

}  // namespace hapticd::test
