// What the List requests answer: always what is in the folders, and no file read twice that has not
// been changed. Who counts the readings is the source of descriptions.
#include "server/daemon/catalogues.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <google/protobuf/stubs/common.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Folders, a clock that is ahead of all that is written, and a count of what is read.
class Shelf {
 public:
  Shelf() {
    std::string name = (fs::temp_directory_path() / "hapticd_lists_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    root = name;
    for (const char* folder : {"scenes", "gestures", "more", "recordings"}) {
      fs::create_directories(root / folder);
    }
  }
  ~Shelf() { fs::remove_all(root); }
  Shelf(const Shelf&) = delete;
  Shelf& operator=(const Shelf&) = delete;

  [[nodiscard]] Catalogues catalogues() {
    const auto describe = [this](const fs::path& path) {
      ++readings;
      return text_of(path);
    };
    return Catalogues({{root / "scenes"},
                       {root / "gestures", root / "more"},
                       root / "recordings",
                       describe,
                       describe,
                       [this] { return now_ns; }});
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(root / name, std::ios::binary) << text;
  }
  [[nodiscard]] static std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void set_age(const std::string& name, std::int64_t seconds) const {
    const timespec time{1'000'000 + seconds, 0};
    const timespec times[2]{time, time};
    REQUIRE(utimensat(AT_FDCWD, (root / name).c_str(), times, 0) == 0);
  }

  fs::path root;
  int readings = 0;
  /// Long after anything was written: files are known once they have been read.
  std::int64_t now_ns = std::int64_t{1} << 62U;
};

std::vector<std::string> texts(const std::vector<ListedName>& list) {
  std::vector<std::string> all;
  all.reserve(list.size());
  for (const ListedName& each : list) all.push_back(each.name + "=" + each.description);
  return all;
}

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("a gesture's file is read once, however often the list is asked for") {
  Shelf shelf;
  for (const char* name : {"b", "a", "c"}) {
    shelf.write("gestures/" + std::string(name) + ".textproto", name);
  }
  shelf.write("gestures/notes.txt", "no gesture");
  Catalogues catalogues = shelf.catalogues();
  for (int i = 0; i < 100; ++i) CHECK(texts(catalogues.gestures()) == Texts{"a=a", "b=b", "c=c"});
  CHECK(shelf.readings == 3);
}

TEST_CASE("scenes are described as gestures are, in one line of 400 bytes at most") {
  Shelf shelf;
  shelf.write("scenes/a.textproto", "A wall.\nTo get used to a device.");
  shelf.write("scenes/b.textproto", std::string(399, 'x') + "\u00e9 and more");
  Catalogues catalogues = shelf.catalogues();
  for (int i = 0; i < 100; ++i) {
    CHECK(texts(catalogues.scenes()) == Texts{"a=A wall.", "b=" + std::string(399, 'x')});
  }
  CHECK(shelf.readings == 2);
}

TEST_CASE("a file that cannot be described is not read again and again either") {
  Shelf shelf;
  shelf.write("gestures/broken.textproto", "");
  Catalogues catalogues = shelf.catalogues();
  for (int i = 0; i < 100; ++i) CHECK(texts(catalogues.gestures()) == Texts{"broken="});
  CHECK(shelf.readings == 1);
}

TEST_CASE("what has just been written is not taken to be known: the system's times are coarse") {
  Shelf shelf;
  struct timespec now {};
  REQUIRE(clock_gettime(CLOCK_REALTIME, &now) == 0);
  shelf.now_ns = kSecond_ns * now.tv_sec;
  shelf.write("gestures/a.textproto", "one");
  Catalogues catalogues = shelf.catalogues();
  CHECK(texts(catalogues.gestures()) == Texts{"a=one"});
  CHECK(texts(catalogues.gestures()) == Texts{"a=one"});
  CHECK(shelf.readings == 2);
  shelf.now_ns += 1'000 * kSecond_ns;
  CHECK(texts(catalogues.gestures()) == Texts{"a=one"});
  CHECK(texts(catalogues.gestures()) == Texts{"a=one"});
  CHECK(shelf.readings == 3);
}

TEST_CASE("recordings are listed oldest first, and in a new order a second after it has changed") {
  Shelf shelf;
  shelf.write("recordings/x.mcap", "");
  shelf.write("recordings/y.mcap", "");
  shelf.set_age("recordings/x.mcap", 1);
  shelf.set_age("recordings/y.mcap", 2);
  Catalogues catalogues = shelf.catalogues();
  CHECK(texts(catalogues.recordings()) == Texts{"x.mcap=", "y.mcap="});
  shelf.set_age("recordings/x.mcap", 3);
  shelf.now_ns += kSecond_ns;
  CHECK(texts(catalogues.recordings()) == Texts{"y.mcap=", "x.mcap="});
  shelf.write("recordings/z.mcap", "");
  CHECK(catalogues.recordings().size() == 3);
  fs::remove_all(shelf.root / "recordings");
  CHECK(catalogues.recordings().empty());
}

TEST_CASE("a list has 4096 names at most: of scenes the first, of recordings the newest") {
  Shelf shelf;
  for (int i = 0; i < 4100; ++i) {
    shelf.write("scenes/" + std::to_string(10'000 + i) + ".textproto", "");
    shelf.write("recordings/" + std::to_string(10'000 + i) + ".mcap", "");
    shelf.set_age("recordings/" + std::to_string(10'000 + i) + ".mcap", i);
  }
  Catalogues catalogues = shelf.catalogues();
  REQUIRE(catalogues.scenes().size() == 4096);
  CHECK(catalogues.scenes().back().name == "14095");
  REQUIRE(catalogues.recordings().size() == 4096);
  CHECK(catalogues.recordings().front().name == "10004.mcap");
  CHECK(catalogues.recordings().back().name == "14099.mcap");
}

TEST_CASE("whatever is done to the folders, the lists are what a new reader would find") {
  Shelf shelf;
  Catalogues kept = shelf.catalogues();
  SplitMix64 random(41);
  const std::int64_t rounds = scaled(3'000);
  for (std::int64_t i = 0; i < rounds; ++i) {
    const std::string folder = std::array{"gestures/", "more/", "scenes/"}[random.below(3)];
    const std::string name(1, static_cast<char>('a' + random.below(5)));
    const fs::path path = shelf.root / (folder + name + ".textproto");
    switch (random.below(5)) {
      case 0:
        fs::remove_all(path);
        break;
      case 1:  // In place, as long as before and with the time it had.
        if (!fs::is_regular_file(path)) break;
        {
          const auto time = fs::last_write_time(path);
          shelf.write(folder + name + ".textproto", std::to_string(1'000 + random.below(1'000)));
          fs::last_write_time(path, time);
        }
        break;
      case 2: {
        std::error_code ignored;
        const std::string other(1, static_cast<char>('a' + random.below(5)));
        fs::rename(path, shelf.root / (folder + other + ".textproto"), ignored);
        break;
      }
      case 3:
        if (!fs::exists(path)) fs::create_directory(path);
        break;
      default:
        if (!fs::is_directory(path)) {
          shelf.write(folder + name + ".textproto", std::to_string(1'000 + random.below(1'000)));
        }
        break;
    }
    // The clock stands where what was written is young, so that nothing rests on coarse times.
    struct timespec now {};
    REQUIRE(clock_gettime(CLOCK_REALTIME, &now) == 0);
    shelf.now_ns = kSecond_ns * now.tv_sec + now.tv_nsec;
    Catalogues fresh = shelf.catalogues();
    REQUIRE(texts(kept.gestures()) == texts(fresh.gestures()));
    REQUIRE(texts(kept.scenes()) == texts(fresh.scenes()));
  }
}

TEST_CASE("only what can be asked for by its name, and told, is listed") {
  Shelf shelf;
  const std::string long_name(64, 'a');
  const std::string too_long(65, 'a');
  for (const std::string name : {"good", "\xc3\xa4", ".hidden", "a\001b", "a\nb", "a\x7f", "a\377b",
                                 "\xc3", "Good", "a b", long_name.c_str(), too_long.c_str()}) {
    shelf.write("scenes/" + name + ".textproto", "");
    shelf.write("gestures/" + name + ".textproto", "x");
    shelf.write("recordings/" + name + ".mcap", "");
  }
  fs::create_directories(shelf.root / "scenes/folder.textproto");
  fs::create_directories(shelf.root / "gestures/folder.textproto");
  fs::create_symlink("nowhere", shelf.root / "scenes/dangling.textproto");
  fs::create_symlink("good.textproto", shelf.root / "scenes/link.textproto");
  Catalogues catalogues = shelf.catalogues();
  CHECK(texts(catalogues.scenes()) == Texts{long_name + "=", "good=", "link="});
  CHECK(texts(catalogues.gestures()) == Texts{long_name + "=x", "good=x"});
  for (const ListedName& each : catalogues.recordings()) {
    CHECK(google::protobuf::internal::IsStructurallyValidUTF8(each.name));
  }
  CHECK(catalogues.recordings().size() == 10);
}

}  // namespace hapticd::test
