// What can be wrong with a triangle mesh that is to become a sphere-tree, where, and what to do
// about it; and the few repairs that cannot change the shape. Offline.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

enum class MeshFault : std::uint8_t {
  kNoTriangles,
  kNotFinite,        ///< a coordinate is infinite or no number
  kIndexOutOfRange,  ///< a triangle names a vertex that does not exist
  kCollapsed,        ///< a triangle with two corners at one place
  kFlat,             ///< a triangle without area, its corners on one line
  kOpenEdge,         ///< an edge of one triangle: the surface has a hole
  kCrowdedEdge,      ///< an edge of three or more triangles
  kTurned,           ///< neighbours with opposite ideas of outside
  kInsideOut,        ///< closed, but all triangles face inwards
  kUnits,            ///< a size that no hand plays with
  kPieces,           ///< the surface is not connected
  kCrossing,         ///< triangles that pass through each other
};

enum class FaultSeverity : std::uint8_t {
  kNote,     ///< may well be meant
  kWarning,  ///< a tree can be made, but look at it
  kError,    ///< inside and outside are not defined: no tree
};

struct MeshFinding {
  MeshFault fault;
  FaultSeverity severity;
  std::int64_t count;     ///< of triangles, edges, vertices or pieces
  std::int32_t triangle;  ///< the first of them; -1 where none is meant
  Vector3 p;              ///< where, m
};

/// Bounding box diagonals outside are taken for a wrong unit, m. Normal values 1 mm and 10 m; a
/// wider range lets metres for millimetres pass.
inline constexpr double kMinDiagonal = 1e-3;
inline constexpr double kMaxDiagonal = 10.0;
/// Triangles above which crossings are not looked for: the search takes seconds there.
inline constexpr std::size_t kMaxTrianglesForCrossings = 500'000;

struct MeshReport {
  std::vector<MeshFinding> findings;  ///< in the order of MeshFault, one per kind
  double diagonal = 0.0;              ///< of the bounding box, m
  double volume = 0.0;                ///< m^3; meaningful for a closed mesh
  double area = 0.0;                  ///< m^2
  std::int32_t pieces = 0;            ///< connected parts
};

/// All findings of `mesh`, whose equal vertices must be joined (weld). Never throws for any mesh.
/// O(n log n), crossings about O(n^1.5).
[[nodiscard]] MeshReport check_mesh(const TriangleMesh& mesh);

/// Whether a tree can be made: no finding is an error.
[[nodiscard]] bool usable(const MeshReport& report);

/// The finding as a sentence with its place, and a second one with the remedy.
[[nodiscard]] std::string describe(const MeshFinding& finding);

/// Joins vertices at exactly the same place, keeping the order of their first appearance, and drops
/// vertices that no triangle uses. Indices valid. O(n log n).
[[nodiscard]] TriangleMesh weld(const TriangleMesh& mesh);

struct MeshRepair {
  std::int64_t dropped = 0;  ///< collapsed triangles
  std::int64_t flipped = 0;  ///< triangles turned round
};

/// Drops collapsed triangles, turns neighbours the same way, and turns pieces that are inside out
/// unless they may be a cavity of another piece (their box lies inside its box). Changes no
/// vertex. `mesh` welded, finite, indices valid.
MeshRepair repair_mesh(TriangleMesh& mesh);

}  // namespace hapticd
