// Welding and the repairs that cannot change the shape. See mesh_check.h.
#include <algorithm>
#include <bit>
#include <numeric>

#include "server/model/packing/mesh_check.h"
#include "server/model/packing/mesh_edges.h"

namespace hapticd {
namespace {

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Orders places, whatever their coordinates: equal ones, and only those, have equal keys.
std::array<std::uint64_t, 3> key(const Vector3& p) {
  // + 0.0 takes the sign from zero.
  return {std::bit_cast<std::uint64_t>(p.x() + 0.0), std::bit_cast<std::uint64_t>(p.y() + 0.0),
          std::bit_cast<std::uint64_t>(p.z() + 0.0)};
}

/// Whether each triangle has to be turned so that it agrees with the first of its piece; sides of
/// crowded edges say nothing.
std::vector<bool> disagreements(const TriangleMesh& mesh) {
  struct Link {
    std::int32_t from, to;
    bool opposite;
  };
  std::vector<Link> links;
  for_each_edge(mesh_edges(mesh), [&](std::span<const MeshEdge> sides) {
    if (sides.size() != 2) return;
    const bool opposite = sides[0].forward == sides[1].forward;
    links.push_back({sides[0].triangle, sides[1].triangle, opposite});
    links.push_back({sides[1].triangle, sides[0].triangle, opposite});
  });
  std::sort(links.begin(), links.end(), [](const Link& a, const Link& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  std::vector<std::size_t> first(mesh.triangles.size() + 1, links.size());
  for (std::size_t k = links.size(); k-- > 0;) first[index(links[k].from)] = k;

  std::vector<bool> turn(mesh.triangles.size());
  std::vector<bool> seen(mesh.triangles.size());
  for (std::size_t start = 0; start < mesh.triangles.size(); ++start) {
    if (seen[start]) continue;
    seen[start] = true;
    std::vector<std::size_t> rest{start};
    while (!rest.empty()) {
      const std::size_t t = rest.back();
      rest.pop_back();
      for (std::size_t k = first[t]; k < links.size() && index(links[k].from) == t; ++k) {
        const std::size_t u = index(links[k].to);
        if (seen[u]) continue;
        seen[u] = true;
        turn[u] = turn[t] != links[k].opposite;
        rest.push_back(u);
      }
    }
  }
  return turn;
}

struct Piece {
  Vector3 low{0.0, 0.0, 0.0}, high{0.0, 0.0, 0.0};
  double volume = 0.0;
  bool empty = true;
};

std::vector<Piece> measure_pieces(const TriangleMesh& mesh,
                                  const std::vector<std::int32_t>& piece_of) {
  std::vector<Piece> pieces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (index(piece_of[t]) >= pieces.size()) pieces.resize(index(piece_of[t]) + 1);
    Piece& piece = pieces[index(piece_of[t])];
    piece.volume += cone_volume_times_six(mesh, mesh.triangles[t]);
    for (const std::int32_t i : mesh.triangles[t]) {
      const Vector3& p = mesh.vertices[index(i)];
      piece.low = piece.empty ? p : Vector3(piece.low.cwiseMin(p));
      piece.high = piece.empty ? p : Vector3(piece.high.cwiseMax(p));
      piece.empty = false;
    }
  }
  return pieces;
}

bool may_be_cavity(const std::vector<Piece>& pieces, std::size_t n) {
  for (std::size_t m = 0; m < pieces.size(); ++m) {
    if (m != n && (pieces[m].low.array() < pieces[n].low.array()).all() &&
        (pieces[n].high.array() < pieces[m].high.array()).all()) {
      return true;
    }
  }
  return false;
}

}  // namespace

TriangleMesh weld(const TriangleMesh& mesh) {
  std::vector<std::int32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const auto p = key(mesh.vertices[index(a)]);
    const auto q = key(mesh.vertices[index(b)]);
    return p != q ? p < q : a < b;
  });
  // same[i]: the first vertex at the place of vertex i.
  std::vector<std::int32_t> same(mesh.vertices.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool equal =
        k > 0 && key(mesh.vertices[index(order[k])]) == key(mesh.vertices[index(order[k - 1])]);
    same[index(order[k])] = equal ? same[index(order[k - 1])] : order[k];
  }
  TriangleMesh welded;
  std::vector<std::int32_t> renamed(mesh.vertices.size(), -1);
  std::vector<bool> used(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    for (const std::int32_t i : t) used[index(same[index(i)])] = true;
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!used[i]) continue;
    renamed[i] = static_cast<std::int32_t>(welded.vertices.size());
    welded.vertices.push_back(mesh.vertices[i]);
  }
  welded.triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    welded.triangles.push_back({renamed[index(same[index(t[0])])],
                                renamed[index(same[index(t[1])])],
                                renamed[index(same[index(t[2])])]});
  }
  return welded;
}

MeshRepair repair_mesh(TriangleMesh& mesh) {
  MeshRepair repair;
  repair.dropped = static_cast<std::int64_t>(std::erase_if(mesh.triangles, [](const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  }));
  std::vector<bool> turned = disagreements(mesh);
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
  const std::vector<std::int32_t> piece_of = mesh_pieces(mesh);
  const std::vector<Piece> pieces = measure_pieces(mesh, piece_of);
  std::vector<bool> wrong(pieces.size());
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    wrong[n] = pieces[n].volume < 0.0 && !may_be_cavity(pieces, n);
  }
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (wrong[index(piece_of[t])]) {
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      turned[t] = !turned[t];
    }
  }
  repair.flipped = std::count(turned.begin(), turned.end(), true);
  return repair;
}

}  // namespace hapticd
