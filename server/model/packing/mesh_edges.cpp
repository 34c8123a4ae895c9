// See mesh_edges.h.
#include "server/model/packing/mesh_edges.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace hapticd {
namespace {

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

std::int32_t root_of(std::vector<std::int32_t>& parent, std::int32_t i) {
  while (parent[index(i)] != i) {
    parent[index(i)] = parent[index(parent[index(i)])];
    i = parent[index(i)];
  }
  return i;
}

}  // namespace

std::vector<MeshEdge> mesh_edges(const TriangleMesh& mesh) {
  std::vector<MeshEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles[t][k];
      const std::int32_t b = mesh.triangles[t][(k + 1) % 3];
      if (a == b) continue;
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const MeshEdge& a, const MeshEdge& b) {
    return std::tie(a.low, a.high, a.triangle, a.forward) <
           std::tie(b.low, b.high, b.triangle, b.forward);
  });
  return edges;
}

void for_each_edge(std::span<const MeshEdge> edges,
                   const std::function<void(std::span<const MeshEdge>)>& visit) {
  std::size_t begin = 0;
  while (begin < edges.size()) {
    std::size_t end = begin + 1;
    while (end < edges.size() && edges[end].low == edges[begin].low &&
           edges[end].high == edges[begin].high) {
      ++end;
    }
    visit(edges.subspan(begin, end - begin));
    begin = end;
  }
}

std::vector<std::int32_t> mesh_pieces(const TriangleMesh& mesh) {
  std::vector<std::int32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Triangle& t : mesh.triangles) {
    for (const std::int32_t other : {t[1], t[2]}) {
      const std::int32_t a = root_of(parent, t[0]);
      const std::int32_t b = root_of(parent, other);
      parent[index(std::max(a, b))] = std::min(a, b);
    }
  }
  std::vector<std::int32_t> number(mesh.vertices.size(), -1);
  std::vector<std::int32_t> pieces;
  pieces.reserve(mesh.triangles.size());
  std::int32_t next = 0;
  for (const Triangle& t : mesh.triangles) {
    std::int32_t& piece = number[index(root_of(parent, t[0]))];
    if (piece < 0) piece = next++;
    pieces.push_back(piece);
  }
  return pieces;
}

double cone_volume_times_six(const TriangleMesh& mesh, const Triangle& t) {
  const Vector3& a = mesh.vertices[index(t[0])];
  return a.dot(mesh.vertices[index(t[1])].cross(mesh.vertices[index(t[2])]));
}

}  // namespace hapticd
