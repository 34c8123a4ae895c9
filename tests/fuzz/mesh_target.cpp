// See mesh_target.h.
#include "tests/fuzz/mesh_target.h"

#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/model/mesh_file.h"
#include "server/model/packing/mesh_check.h"
#include "tests/fuzz/plain_line.h"
#include "tests/fuzz/scratch_folder.h"

namespace hapticd::test {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

void check_indices(const TriangleMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::int32_t i : triangle) {
      require(i >= 0 && static_cast<std::size_t>(i) < used.size(), "a vertex that is not there");
      used[static_cast<std::size_t>(i)] = true;
    }
  }
  for (const bool each : used) require(each, "a vertex of no triangle");
}

/// That it is what a tree can be made of.
void check_inside(const TriangleMesh& mesh) {
  require(!mesh.triangles.empty(), "an inside without a surface");
  for (const Vector3& p : mesh.vertices) require(p.allFinite(), "a vertex that is nowhere");
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = t[k];
      const std::int32_t to = t[(k + 1) % 3];
      require(from != to, "a triangle with two corners at one place");
      require(edges.emplace(from, to).second, "an edge of two triangles that disagree");
    }
  }
  for (const auto& [from, to] : edges) require(edges.count({to, from}) == 1, "a hole");
}

bool check_read(TriangleMesh mesh) {
  check_indices(mesh);
  MeshReport report = check_mesh(mesh);
  for (const MeshFinding& finding : report.findings) {
    require(is_plain_line(describe(finding)), "a finding that a terminal obeys");
    if (finding.fault == MeshFault::kNotFinite || finding.fault == MeshFault::kNoTriangles) {
      return false;
    }
  }
  if (!usable(report)) {
    repair_mesh(mesh);
    for (const Triangle& t : mesh.triangles) {
      for (const std::int32_t i : t) {
        require(i >= 0 && static_cast<std::size_t>(i) < mesh.vertices.size(), "a bad repair");
      }
    }
    report = check_mesh(mesh);
  }
  if (usable(report)) check_inside(mesh);
  return usable(report);
}

void check_refusal(const std::string& text, const std::string& path) {
  require(text.starts_with(path + ": "), "a refusal that does not name its file");
  require(text.find(". ") != std::string::npos, "a refusal without a remedy");
  require(is_plain_line(text.substr(path.size())), "a refusal that a terminal obeys");
}

}  // namespace

bool check_mesh_bytes(std::span<const std::uint8_t> bytes) {
  static const ScratchFolder folder;
  if (bytes.empty()) return false;
  const unsigned letter = bytes[0] | 0x20U;
  const std::string ending = letter == 's' ? ".stl" : letter == 'p' ? ".ply" : ".obj";
  const std::string path = folder.write("fuzzed" + ending, bytes.subspan(1));
  TriangleMesh mesh;
  try {
    mesh = read_mesh(path, (bytes[0] & 0x20U) == 0 ? 1e-3 : 1.0).mesh;
  } catch (const std::runtime_error& error) {
    check_refusal(error.what(), path);
    return false;
  }
  return check_read(std::move(mesh));
}

}  // namespace hapticd::test
