// See mesh_file.h.
#include "server/model/mesh_file.h"

#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "server/model/isolated.h"
#include "server/model/packing/mesh_check.h"
#include "server/model/polygon_cutting.h"

namespace hapticd {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Processor time that reading may take: this much, s, and one more second per this many bytes.
/// Damaged files make some readers of assimp loop for ever; whole ones take a tenth of this.
constexpr unsigned kReadSeconds = 1;
constexpr std::uint64_t kReadBytesPerSecond = 1'000'000;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

std::string ending(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// A node of the scene and what it moves its meshes by.
struct Placed {
  const aiNode* node;
  aiMatrix4x4 transform;
};

void refuse_polygon(const aiMesh& part, unsigned f, const std::string& fault) {
  const aiFace& face = part.mFaces[f];
  const aiVector3D& p = part.mVertices[face.mIndices[0]];
  std::array<char, 160> where{};
  std::snprintf(where.data(), where.size(), "polygon of %u corners that begins at %g %g %g ",
                face.mNumIndices, double{p.x}, double{p.y}, double{p.z});
  const std::string name = part.mName.C_Str();
  throw std::runtime_error("face " + std::to_string(f + 1) +
                           (name.empty() ? "" : " of '" + name + "'") + ", a " + where.data() +
                           fault + ". Triangulate it in the program it comes from");
}

/// The triangles of face `f` of `part`, whose vertices begin at `offset` in `mesh`. Points and
/// lines have none.
std::vector<Triangle> triangles_of(const aiMesh& part, unsigned f, std::size_t offset,
                                   const TriangleMesh& mesh) {
  const aiFace& face = part.mFaces[f];
  if (face.mNumIndices < 3) return {};
  std::vector<Vector3> corners;
  std::vector<std::int32_t> places;
  bool finite = true;
  for (unsigned k = 0; k < face.mNumIndices; ++k) {
    if (face.mIndices[k] >= part.mNumVertices)
      throw std::runtime_error("a face names a vertex that does not exist");
    places.push_back(static_cast<std::int32_t>(offset + face.mIndices[k]));
    corners.push_back(mesh.vertices[static_cast<std::size_t>(places.back())]);
    finite = finite && corners.back().allFinite();
  }
  if (!finite) return {{places[0], places[1], places[2]}};  // check_mesh finds it
  CutPolygon cut = cut_polygon(corners);
  if (!cut.fault.empty()) refuse_polygon(part, f, cut.fault);
  for (Triangle& t : cut.triangles) {
    for (std::int32_t& i : t) i = places[static_cast<std::size_t>(i)];
  }
  return std::move(cut.triangles);
}

void append(const aiMesh& part, const aiMatrix4x4& transform, double scale, TriangleMesh& mesh) {
  const std::size_t offset = mesh.vertices.size();
  const auto too_many = [&](std::size_t more) {
    if (mesh.triangles.size() + more <= kMaxTriangles) return;
    throw std::runtime_error("more than 5 million triangles, far more than a tree can use");
  };
  if (offset + part.mNumVertices > std::numeric_limits<std::int32_t>::max())
    too_many(kMaxTriangles + 1);
  too_many(part.mNumFaces);
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D p = transform * part.mVertices[i];
    mesh.vertices.emplace_back(double{p.x} * scale, double{p.y} * scale, double{p.z} * scale);
  }
  // A mirror turns triangles inside out.
  const bool mirrored = transform.Determinant() < 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    for (Triangle t : triangles_of(part, f, offset, mesh)) {
      if (mirrored) std::swap(t[1], t[2]);
      mesh.triangles.push_back(t);
    }
    too_many(0);
  }
}

TriangleMesh collect(const aiScene& scene, double scale) {
  TriangleMesh mesh;
  std::vector<Placed> rest{{scene.mRootNode, aiMatrix4x4()}};
  while (!rest.empty()) {
    const Placed placed = rest.back();
    rest.pop_back();
    const aiMatrix4x4 transform = placed.transform * placed.node->mTransformation;
    for (unsigned i = 0; i < placed.node->mNumMeshes; ++i) {
      append(*scene.mMeshes[placed.node->mMeshes[i]], transform, scale, mesh);
    }
    // Backwards, so that the first child comes next.
    for (unsigned i = placed.node->mNumChildren; i-- > 0;) {
      rest.push_back({placed.node->mChildren[i], transform});
    }
  }
  return mesh;
}

void put(Bytes& out, const std::string& text) { out.insert(out.end(), text.begin(), text.end()); }

void put(Bytes& out, std::uint64_t value, unsigned bytes) {
  for (unsigned k = 0; k < bytes; ++k) out.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

/// Assimp 5.2 takes a first byte 0x0a of a binary PLY's numbers for one more line end and reads all
/// of them shifted. The next byte value moves the first number by a unit in its last place.
void step_over_line_end(Bytes& ply) {
  constexpr std::string_view kHeaderEnd = "end_header\n";
  constexpr std::string_view kBinary = "format binary";
  const auto end = std::search(ply.begin(), ply.end(), kHeaderEnd.begin(), kHeaderEnd.end());
  const bool binary = std::search(ply.begin(), end, kBinary.begin(), kBinary.end()) != end;
  if (!binary || ply.end() - end <= std::ssize(kHeaderEnd)) return;
  std::uint8_t& first = end[std::ssize(kHeaderEnd)];
  if (first == '\n') ++first;
}

/// Runs in the child: throws std::runtime_error without the path. `bytes` are those of the file;
/// formats that may refer to further files are read from where it is.
TriangleMesh import(const std::string& path, Bytes bytes, const std::string& kind, double scale) {
  Assimp::Importer importer;
  if (kind == ".ply") step_over_line_end(bytes);
  const aiScene* scene = kind == ".ply"
                             ? importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, "ply")
                             : importer.ReadFile(path, 0);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error("not a readable " + kind + " file (" + importer.GetErrorString() +
                             ")");
  }
  return collect(*scene, scale);
}

Bytes pack(const TriangleMesh& mesh) {
  Bytes out(2 * sizeof(std::uint64_t) + mesh.vertices.size() * sizeof(Array3) +
            mesh.triangles.size() * sizeof(Triangle));
  std::uint8_t* at = out.data();
  const auto put_raw = [&at](const void* from, std::size_t size) {
    std::memcpy(at, from, size);
    at += size;
  };
  for (const std::uint64_t count : {mesh.vertices.size(), mesh.triangles.size()}) {
    put_raw(&count, sizeof count);
  }
  for (const Vector3& p : mesh.vertices) put_raw(p.data(), sizeof(Array3));
  for (const Triangle& t : mesh.triangles) put_raw(t.data(), sizeof t);
  return out;
}

TriangleMesh unpack(const Bytes& bytes) {
  std::array<std::uint64_t, 2> counts{};
  if (bytes.size() < sizeof counts) throw std::runtime_error("the reader crashed");
  std::memcpy(counts.data(), bytes.data(), sizeof counts);
  TriangleMesh mesh;
  mesh.vertices.resize(counts[0]);
  mesh.triangles.resize(counts[1]);
  const std::uint8_t* at = bytes.data() + sizeof counts;
  for (Vector3& p : mesh.vertices) {
    std::memcpy(p.data(), at, sizeof(Array3));
    at += sizeof(Array3);
  }
  for (Triangle& t : mesh.triangles) {
    std::memcpy(t.data(), at, sizeof t);
    at += sizeof t;
  }
  return mesh;
}

Bytes ply(const TriangleMesh& mesh) {
  Bytes out;
  put(out, "ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex " +
               std::to_string(mesh.vertices.size()) +
               "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
               std::to_string(mesh.triangles.size()) +
               "\nproperty list uchar int vertex_indices\nend_header\n");
  for (const Vector3& p : mesh.vertices) {
    for (const double x : p) put(out, std::bit_cast<std::uint32_t>(static_cast<float>(x)), 4);
  }
  for (const Triangle& t : mesh.triangles) {
    out.push_back(3);
    for (const std::int32_t i : t) put(out, static_cast<std::uint32_t>(i), 4);
  }
  return out;
}

Bytes obj(const TriangleMesh& mesh) {
  Bytes out;
  put(out, "# metres\n");
  std::array<char, 128> line{};
  for (const Vector3& p : mesh.vertices) {
    std::snprintf(line.data(), line.size(), "v %.9g %.9g %.9g\n", p.x(), p.y(), p.z());
    put(out, line.data());
  }
  for (const Triangle& t : mesh.triangles) {
    std::snprintf(line.data(), line.size(), "f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
    put(out, line.data());
  }
  return out;
}

}  // namespace

Bytes read_bytes(const std::string& path, std::uint64_t largest) {
  std::error_code error;
  const bool regular = std::filesystem::is_regular_file(path, error);
  if (error) fail(path, error.message() + ". Give the path of a file that can be read");
  if (!regular) fail(path, "not a file");
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) fail(path, error.message());
  if (size > largest) {
    fail(path, std::to_string(size) + " bytes; at most " + std::to_string(largest) +
                   " are read. Reduce the mesh");
  }
  Bytes bytes(size);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!file) fail(path, "cannot be read. Are the permissions right?");
  return bytes;
}

void write_bytes(const std::string& path, const Bytes& bytes) {
  std::error_code none;
  if (std::filesystem::is_regular_file(path, none) &&
      std::filesystem::file_size(path, none) == bytes.size() &&
      read_bytes(path, bytes.size()) == bytes) {
    return;
  }
  const std::string temporary = path + ".part";
  const auto give_up = [&](const std::string& why) {
    if (std::filesystem::is_regular_file(temporary, none)) std::filesystem::remove(temporary, none);
    fail(path, why);
  };
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) give_up("cannot be written. Does the folder exist, and is there space?");
  }
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (error) give_up(error.message());
}

SourceMesh read_mesh(const std::string& path, double metres_per_unit) {
  constexpr std::array<const char*, 5> kEndings{".obj", ".stl", ".ply", ".gltf", ".glb"};
  const std::string kind = ending(path);
  if (std::find(kEndings.begin(), kEndings.end(), kind) == kEndings.end()) {
    fail(path,
         "'" + kind + "' is not a mesh file known here. Export it as .obj .stl .ply .gltf or .glb");
  }
  SourceMesh source;
  const Bytes bytes = read_bytes(path, kMaxMeshFile);
  source.hash = content_hash(bytes);
  // The commonest damage, a file cut off in its header, would make assimp loop until its time is
  // up.
  constexpr std::string_view kHeaderEnd = "end_header";
  if (kind == ".ply" && std::search(bytes.begin(), bytes.end(), kHeaderEnd.begin(),
                                    kHeaderEnd.end()) == bytes.end()) {
    fail(path, "not a PLY file, or cut off in its header. Export it again");
  }
  const auto cpu_seconds = kReadSeconds + static_cast<unsigned>(bytes.size() / kReadBytesPerSecond);
  try {
    source.mesh = unpack(run_isolated(
        [&] { return pack(import(path, bytes, kind, metres_per_unit)); }, cpu_seconds));
  } catch (const std::runtime_error& error) {
    fail(path, std::string(error.what()) + ". Export it again, or as another format");
  }
  source.mesh = weld(source.mesh);
  return source;
}

void write_mesh(const std::string& path, const TriangleMesh& mesh) {
  const std::string kind = ending(path);
  if (kind != ".ply" && kind != ".obj") fail(path, "meshes are written as .ply or .obj");
  write_bytes(path, kind == ".ply" ? ply(mesh) : obj(mesh));
}

ContentHash mesh_hash(const TriangleMesh& mesh) {
  Bytes bytes;
  bytes.reserve(24 * mesh.vertices.size() + 12 * mesh.triangles.size());
  for (const Vector3& p : mesh.vertices) {
    for (const double x : p) put(bytes, std::bit_cast<std::uint64_t>(x), 8);
  }
  for (const Triangle& t : mesh.triangles) {
    for (const std::int32_t i : t) put(bytes, static_cast<std::uint32_t>(i), 4);
  }
  return content_hash(bytes);
}

}  // namespace hapticd
