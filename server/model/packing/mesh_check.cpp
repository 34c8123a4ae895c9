// The findings; repairs are mesh_repair.cpp. See mesh_check.h.
#include "server/model/packing/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/model/packing/mesh_crossings.h"
#include "server/model/packing/mesh_edges.h"

namespace hapticd {
namespace {

/// A triangle whose height is below this share of its longest side counts as flat: its normal is
/// rounding noise. Normal value 1e-12.
constexpr double kFlatShare = 1e-12;

const Vector3& corner(const TriangleMesh& mesh, const Triangle& t, std::size_t k) {
  return mesh.vertices[static_cast<std::size_t>(t[k])];
}

/// Collects one kind of finding.
class Collector {
 public:
  Collector(MeshFault fault, FaultSeverity severity)
      : finding_{fault, severity, 0, -1, Vector3{0.0, 0.0, 0.0}} {}

  void add(std::size_t triangle, const Vector3& p) {
    if (finding_.count++ > 0) return;
    finding_.triangle = static_cast<std::int32_t>(triangle);
    finding_.p = p;
  }
  void add_to(MeshReport& report) const {
    if (finding_.count > 0) report.findings.push_back(finding_);
  }

 private:
  MeshFinding finding_;
};

/// Faults that make everything else meaningless.
void check_numbers(const TriangleMesh& mesh, MeshReport& report) {
  if (mesh.triangles.empty()) {
    report.findings.push_back(
        {MeshFault::kNoTriangles, FaultSeverity::kError, 1, -1, Vector3{0.0, 0.0, 0.0}});
  }
  Collector not_finite(MeshFault::kNotFinite, FaultSeverity::kError);
  Collector out_of_range(MeshFault::kIndexOutOfRange, FaultSeverity::kError);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::int32_t i : mesh.triangles[t]) {
      if (i < 0 || static_cast<std::size_t>(i) >= mesh.vertices.size()) {
        out_of_range.add(t, Vector3{0.0, 0.0, 0.0});
      } else if (!mesh.vertices[static_cast<std::size_t>(i)].allFinite()) {
        not_finite.add(t, Vector3{0.0, 0.0, 0.0});
      }
    }
  }
  not_finite.add_to(report);
  out_of_range.add_to(report);
}

void measure(const TriangleMesh& mesh, MeshReport& report) {
  Vector3 low = corner(mesh, mesh.triangles[0], 0);
  Vector3 high = low;
  double volume = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      low = low.cwiseMin(corner(mesh, t, k));
      high = high.cwiseMax(corner(mesh, t, k));
    }
    volume += cone_volume_times_six(mesh, t);
    const Vector3 ab = corner(mesh, t, 1) - corner(mesh, t, 0);
    report.area += 0.5 * ab.cross(corner(mesh, t, 2) - corner(mesh, t, 0)).norm();
  }
  report.volume = volume / 6.0;
  report.diagonal = (high - low).norm();
}

void check_triangles(const TriangleMesh& mesh, MeshReport& report) {
  Collector collapsed(MeshFault::kCollapsed, FaultSeverity::kError);
  Collector flat(MeshFault::kFlat, FaultSeverity::kWarning);
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const Triangle& t = mesh.triangles[n];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      collapsed.add(n, corner(mesh, t, 0));
      continue;
    }
    const Vector3 ab = corner(mesh, t, 1) - corner(mesh, t, 0);
    const Vector3 ac = corner(mesh, t, 2) - corner(mesh, t, 0);
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    if (!(ab.cross(ac).norm() > kFlatShare * longest)) flat.add(n, corner(mesh, t, 0));
  }
  collapsed.add_to(report);
  flat.add_to(report);
}

/// Returns whether the mesh is closed and turned one way all over.
bool check_edges(const TriangleMesh& mesh, MeshReport& report) {
  Collector open(MeshFault::kOpenEdge, FaultSeverity::kError);
  Collector crowded(MeshFault::kCrowdedEdge, FaultSeverity::kError);
  Collector turned(MeshFault::kTurned, FaultSeverity::kError);
  const std::size_t before = report.findings.size();
  for_each_edge(mesh_edges(mesh), [&](std::span<const MeshEdge> sides) {
    const MeshEdge& first = sides.front();
    const Vector3 middle = 0.5 * mesh.vertices[static_cast<std::size_t>(first.low)] +
                           0.5 * mesh.vertices[static_cast<std::size_t>(first.high)];
    const auto triangle = static_cast<std::size_t>(first.triangle);
    if (sides.size() == 1) open.add(triangle, middle);
    if (sides.size() > 2) crowded.add(triangle, middle);
    if (sides.size() == 2 && sides[0].forward == sides[1].forward) turned.add(triangle, middle);
  });
  open.add_to(report);
  crowded.add_to(report);
  turned.add_to(report);
  return report.findings.size() == before;
}

void check_whole(const TriangleMesh& mesh, bool closed, MeshReport& report) {
  const Vector3& p = corner(mesh, mesh.triangles[0], 0);
  if (closed && report.volume < 0.0) {
    report.findings.push_back({MeshFault::kInsideOut, FaultSeverity::kError,
                               static_cast<std::int64_t>(mesh.triangles.size()), 0, p});
  }
  if (!(report.diagonal >= kMinDiagonal && report.diagonal <= kMaxDiagonal)) {
    report.findings.push_back(
        {MeshFault::kUnits, FaultSeverity::kWarning, 1, -1, Vector3{report.diagonal, 0.0, 0.0}});
  }
  const std::vector<std::int32_t> pieces = mesh_pieces(mesh);
  const auto last = std::max_element(pieces.begin(), pieces.end());
  report.pieces = *last + 1;
  if (report.pieces > 1) {
    const auto t = std::find(pieces.begin(), pieces.end(), 1) - pieces.begin();
    report.findings.push_back({MeshFault::kPieces, FaultSeverity::kNote, report.pieces,
                               static_cast<std::int32_t>(t),
                               corner(mesh, mesh.triangles[static_cast<std::size_t>(t)], 0)});
  }
  if (mesh.triangles.size() > kMaxTrianglesForCrossings) return;
  const MeshCrossings crossings = find_crossings(mesh);
  if (crossings.count > 0) {
    report.findings.push_back({MeshFault::kCrossing, FaultSeverity::kWarning, crossings.count,
                               crossings.triangle, crossings.p});
  }
}

struct Wording {
  const char* one;      ///< after the count 1, or where nothing is counted
  const char* several;  ///< after another count
  const char* remedy;
};

/// Of faults that are no edge's and no single triangle's.
Wording wording_of_whole(MeshFault fault) {
  if (fault == MeshFault::kUnits) {
    return {"the bounding box is not of a size that a hand can play with", "",
            "If the file is in another unit, say so: --unit mm, --unit cm or --unit in."};
  }
  if (fault == MeshFault::kPieces) {
    return {"piece", "separate pieces", "That is right for a body of several parts."};
  }
  return {"triangle passes through others, so the sign of distances may be wrong there",
          "triangles pass through others, so the sign of distances may be wrong there",
          "Unite the overlapping parts into one surface, and look at the report."};
}

Wording wording(MeshFault fault) {
  switch (fault) {
    case MeshFault::kNoTriangles:
      return {"the mesh has no triangles", "", "Export the surface as triangles or polygons."};
    case MeshFault::kNotFinite:
      return {"corner with coordinates that are not finite",
              "corners with coordinates that are not finite", "Export the mesh again."};
    case MeshFault::kIndexOutOfRange:
      return {"corner names a vertex that does not exist",
              "corners name a vertex that does not exist", "Export the mesh again."};
    case MeshFault::kCollapsed:
      return {"triangle has two corners at one place", "triangles have two corners at one place",
              "--repair drops them."};
    case MeshFault::kFlat:
      return {"triangle has no area", "triangles have no area",
              "Nothing needs to be done unless the report looks wrong."};
    case MeshFault::kOpenEdge:
      return {"edge belongs to one triangle only: the surface has holes, so nothing is inside",
              "edges belong to one triangle only: the surface has holes, so nothing is inside",
              "Close the holes in the program that made the mesh."};
    case MeshFault::kCrowdedEdge:
      return {"edge belongs to three or more triangles", "edges belong to three or more triangles",
              "Separate the parts that touch there, or unite them into one surface."};
    case MeshFault::kTurned:
      return {"edge between triangles with opposite orientation",
              "edges between triangles with opposite orientation",
              "--repair turns them all the same way."};
    case MeshFault::kInsideOut:
      return {"triangle, the only one, faces inwards", "triangles, all of them, face inwards",
              "--repair turns them round."};
    default:
      return wording_of_whole(fault);
  }
}

}  // namespace

MeshReport check_mesh(const TriangleMesh& mesh) {
  MeshReport report;
  check_numbers(mesh, report);
  if (!report.findings.empty()) return report;
  measure(mesh, report);
  check_triangles(mesh, report);
  const bool closed = check_edges(mesh, report);
  check_whole(mesh, closed, report);
  return report;
}

bool usable(const MeshReport& report) {
  return std::none_of(
      report.findings.begin(), report.findings.end(),
      [](const MeshFinding& finding) { return finding.severity == FaultSeverity::kError; });
}

std::string describe(const MeshFinding& finding) {
  const Wording words = wording(finding.fault);
  const bool counted =
      finding.fault != MeshFault::kNoTriangles && finding.fault != MeshFault::kUnits;
  std::string text = counted ? std::to_string(finding.count) + " " : "";
  text += counted && finding.count != 1 ? words.several : words.one;
  char place[160] = "";
  if (finding.fault == MeshFault::kUnits) {
    std::snprintf(place, sizeof place, ": its diagonal is %.4g m", finding.p.x());
  } else if (finding.fault == MeshFault::kNotFinite ||
             finding.fault == MeshFault::kIndexOutOfRange) {
    std::snprintf(place, sizeof place, "; the first is in triangle %d", finding.triangle);
  } else if (finding.triangle >= 0) {
    std::snprintf(place, sizeof place, "; the first at triangle %d, (%.6g, %.6g, %.6g) m",
                  finding.triangle, finding.p.x(), finding.p.y(), finding.p.z());
  }
  return text + place + ". " + words.remedy;
}

}  // namespace hapticd
