// Mesh files: the same tetrahedron in every format, written by hand, is read as that tetrahedron;
// what is damaged is refused with its name and a remedy. Truth: the tetrahedron.
#include "server/model/mesh_file.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "server/model/isolated.h"
#include "server/model/packing/mesh_check.h"
#include "tests/server/model/temporary_folder.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// The corner of a cube: (0,0,0), (1,0,0), (0,1,0), (0,0,1); volume 1/6.
using Corner = std::array<float, 3>;
constexpr std::array<Corner, 4> kCorners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaces{
    {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

constexpr const char* kObj =
    "o tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

std::string binary_stl() {
  BinaryText text;
  text.raw(std::string(80, ' ')).u32(kFaces.size());
  for (const auto& face : kFaces) {
    text.f32(0).f32(0).f32(0);
    for (const std::uint8_t i : face) {
      for (const float x : kCorners[i]) text.f32(x);
    }
    text.u16(0);
  }
  return text.text();
}

std::string ascii_stl() {
  std::string text = "solid t\n";
  for (const auto& face : kFaces) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const std::uint8_t i : face) {
      text += "vertex";
      for (const float x : kCorners[i]) text += " " + std::to_string(x);
      text += "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid t\n";
}

std::string ascii_ply() {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
         "float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

std::string glb_buffer() {
  BinaryText buffer;
  for (const Corner& corner : kCorners) {
    for (const float x : corner) buffer.f32(x);
  }
  for (const auto& face : kFaces) {
    for (const std::uint8_t i : face) buffer.u16(i);
  }
  return buffer.text();
}

/// glTF whose only node moves the mesh by (1, 2, 3) and doubles it.
std::string gltf_json(const std::string& buffer) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,)"
         R"("translation":[1,2,3],"scale":[2,2,2]}],"meshes":[{"primitives":[{"attributes":)"
         R"({"POSITION":0},"indices":1}]}],"buffers":[{)" +
         buffer +
         R"("byteLength":72}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":24}],"accessors":[{"bufferView":0,)"
         R"("componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},)"
         R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})";
}

std::string glb() {
  std::string json = gltf_json("");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = glb_buffer();
  BinaryText text;
  text.raw("glTF").u32(2).u32(static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
  text.u32(static_cast<std::uint32_t>(json.size())).raw("JSON").raw(json);
  text.u32(static_cast<std::uint32_t>(buffer.size())).raw(std::string("BIN\0", 4)).raw(buffer);
  return text.text();
}

void check_tetrahedron(const TriangleMesh& mesh, double side, const Vector3& p) {
  REQUIRE(mesh.vertices.size() == 4);
  REQUIRE(mesh.triangles.size() == 4);
  for (const Corner& corner : kCorners) {
    const Vector3 wanted =
        p + side * Vector3{double{corner[0]}, double{corner[1]}, double{corner[2]}};
    const auto near = [&](const Vector3& v) { return (v - wanted).norm() <= 1e-6 * side; };
    CHECK(std::any_of(mesh.vertices.begin(), mesh.vertices.end(), near));
  }
  const MeshReport report = check_mesh(mesh);
  CHECK(usable(report));
  CHECK(report.volume == doctest::Approx(side * side * side / 6.0));
}

/// What reading says; "" when it reads.
std::string complaint(const std::string& path) {
  try {
    static_cast<void>(read_mesh(path, 1.0));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Whether `text` names `path` and goes on with more than one sentence.
bool names_file_and_remedy(const std::string& text, const std::string& path) {
  return text.starts_with(path + ": ") && text.find(". ") != std::string::npos;
}

}  // namespace

TEST_CASE("every format is read, in its unit") {
  const TemporaryFolder folder;
  const Vector3 origin{0.0, 0.0, 0.0};
  check_tetrahedron(read_mesh(folder.write("t.obj", kObj), 1.0).mesh, 1.0, origin);
  check_tetrahedron(read_mesh(folder.write("b.stl", binary_stl()), 1e-3).mesh, 1e-3, origin);
  check_tetrahedron(read_mesh(folder.write("a.stl", ascii_stl()), 0.1).mesh, 0.1, origin);
  check_tetrahedron(read_mesh(folder.write("t.PLY", ascii_ply()), 0.0254).mesh, 0.0254, origin);
}

TEST_CASE("the nodes of a glTF scene place its meshes, with its buffer inside or beside it") {
  const TemporaryFolder folder;
  check_tetrahedron(read_mesh(folder.write("t.glb", glb()), 0.1).mesh, 0.2, {0.1, 0.2, 0.3});
  static_cast<void>(folder.write("t.bin", glb_buffer()));
  const std::string gltf = folder.write("t.gltf", gltf_json(R"("uri":"t.bin",)"));
  check_tetrahedron(read_mesh(gltf, 1.0).mesh, 2.0, {1.0, 2.0, 3.0});
}

TEST_CASE("polygons are cut into triangles, points and lines left out") {
  const TemporaryFolder folder;
  const std::string cube = folder.write(
      "cube.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nl 1 7\np 3\n");
  const TriangleMesh mesh = read_mesh(cube, 0.1).mesh;
  CHECK(mesh.triangles.size() == 12);
  CHECK(mesh.vertices.size() == 8);
  CHECK(usable(check_mesh(mesh)));
  CHECK(check_mesh(mesh).volume == doctest::Approx(1e-3));
}

TEST_CASE("what is written is read again") {
  const TemporaryFolder folder;
  const SourceMesh source = read_mesh(folder.write("t.obj", kObj), 0.1);
  for (const char* name : {"again.ply", "again.obj"}) {
    write_mesh(folder.path(name), source.mesh);
    check_tetrahedron(read_mesh(folder.path(name), 1.0).mesh, 0.1, {0.0, 0.0, 0.0});
  }
}

TEST_CASE("a binary PLY is read whatever its first byte is, a line end too") {
  const TemporaryFolder folder;
  TriangleMesh mesh = read_mesh(folder.write("t.obj", kObj), 0.1).mesh;
  const double moved = mesh.vertices[0].x();
  for (std::uint32_t low = 0; low < 256; ++low) {
    // A number near the right one with this low byte.
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(moved + 1e-3));
    const auto x = std::bit_cast<float>((bits & ~0xffU) | low);
    mesh.vertices[0].x() = x;
    write_mesh(folder.path("b.ply"), mesh);
    const TriangleMesh again = read_mesh(folder.path("b.ply"), 1.0).mesh;
    REQUIRE(again.triangles == mesh.triangles);
    CHECK(std::abs(again.vertices[0].x() - static_cast<double>(x)) <=
          1.2e-7 * std::abs(static_cast<double>(x)));
  }
}

TEST_CASE("the hash is that of the file's bytes") {
  const TemporaryFolder folder;
  const std::string text = kObj;
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  CHECK(read_mesh(folder.write("t.obj", kObj), 0.1).hash == content_hash(bytes));
}

TEST_CASE("files that are missing, folders, empty, unknown or damaged are refused by name") {
  const TemporaryFolder folder;
  const std::string stl = binary_stl();
  const std::vector<std::string> paths{
      folder.path("missing.obj"),
      folder.write("t.step", kObj),
      folder.write("noending", kObj),
      folder.write("empty.obj", ""),
      folder.write("empty.ply", ""),
      folder.write("short.stl", stl.substr(0, 90)),
      folder.write("header.ply", "ply\nformat ascii 1.0\nelement vertex 4\n"),
      folder.write("text.glb", "this is no glTF at all"),
      folder.write("text.gltf", "{\"asset\":"),
      folder.write("out_of_range.gltf", gltf_json(R"("uri":"nowhere.bin",)")),
  };
  for (const std::string& path : paths) {
    CAPTURE(path);
    CHECK(names_file_and_remedy(complaint(path), path));
  }
  const std::string as_file = folder.path("folder.obj");
  std::filesystem::create_directory(as_file);
  CHECK(complaint(as_file).starts_with(as_file));
}

TEST_CASE("a file above the limit is refused before it is read") {
  const TemporaryFolder folder;
  const std::string path = folder.write("t.obj", kObj);
  CHECK_THROWS_AS(static_cast<void>(read_bytes(path, 10)), std::runtime_error);
  CHECK(read_bytes(path, 1000).size() == std::string(kObj).size());
}

TEST_CASE("damaged files are refused or read as some mesh, and never more") {
  const TemporaryFolder folder;
  SplitMix64 random(11);
  for (const auto& [name, good] : std::vector<std::pair<std::string, std::string>>{
           {"t.obj", kObj}, {"t.stl", binary_stl()}, {"t.ply", ascii_ply()}}) {
    for (std::int64_t trial = 0; trial < scaled(300); ++trial) {
      std::string bad = good;
      // A wrong header of a PLY file costs a second of a reader that loops.
      const std::size_t header = name == "t.ply" ? good.find("end_header") + 11 : 0;
      if (random.chance(0.3)) bad.resize(header + random.below(bad.size() - header));
      for (int k = 0; k < 3 && bad.size() > header; ++k) {
        bad[header + random.below(bad.size() - header)] = static_cast<char>(' ' + random.below(95));
      }
      const std::string path = folder.write(name, bad);
      CAPTURE(bad);
      try {
        static_cast<void>(check_mesh(read_mesh(path, 1.0).mesh));
      } catch (const std::runtime_error& error) {
        REQUIRE(names_file_and_remedy(error.what(), path));
      }
    }
  }
}

TEST_CASE("a reader that crashes or never ends is an error, and nothing more") {
  CHECK_THROWS_WITH_AS(
      static_cast<void>(run_isolated([]() -> std::vector<std::uint8_t> { std::abort(); }, 1)),
      "the reader crashed", std::runtime_error);
  CHECK_THROWS_WITH_AS(static_cast<void>(run_isolated(
                           []() -> std::vector<std::uint8_t> {
                             const volatile bool on = true;
                             while (on) {
                             }
                             return {};
                           },
                           1)),
                       "the reader took too long or too much memory", std::runtime_error);
  CHECK_THROWS_WITH_AS(
      static_cast<void>(run_isolated(
          []() -> std::vector<std::uint8_t> { throw std::runtime_error("so it is"); }, 1)),
      "so it is", std::runtime_error);
}

TEST_CASE("only .ply and .obj are written, not where no folder is, and whole or not at all") {
  const TemporaryFolder folder;
  const TriangleMesh mesh = read_mesh(folder.write("t.obj", kObj), 0.1).mesh;
  CHECK_THROWS_AS(write_mesh(folder.path("t.stl"), mesh), std::runtime_error);
  CHECK_THROWS_AS(write_mesh(folder.path("no/folder/t.ply"), mesh), std::runtime_error);
  // What cannot take its place is not left beside it.
  std::filesystem::create_directories(folder.path("there.ply/full"));
  CHECK_THROWS_AS(write_mesh(folder.path("there.ply"), mesh), std::runtime_error);
  CHECK_FALSE(std::filesystem::exists(folder.path("there.ply.part")));
}

}  // namespace hapticd::test
