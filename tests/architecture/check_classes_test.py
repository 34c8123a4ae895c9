#!/usr/bin/python3
"""The check of classes and parameters finds what it is there for, and the outline it stands on reads C++ as the compiler does."""
import os
import sys
import tempfile
import unittest

import check_classes
import count_parameters
import cpp_outline
from source_tree import ROOT

sys.path.insert(0, f"{ROOT}/deploy/cmake")
import unity_groups  # noqa: E402

HEADER = """// What it is.
#pragma once
namespace hapticd {
class Player {
 public:
  Player();
  void play();
  void stop() noexcept;
 private:
  int place_ = 0;
};
}  // namespace hapticd
"""
PLAYER = "server/a/player.h"
PLAY = "namespace hapticd {\nPlayer::Player() : place_{1} {}\nvoid Player::play() { if (place_ > 0) { stop(); } }\n"
STOP = "void Player::stop() noexcept { place_ = {}; }\n"


def members_of(text):
    return [member.name for member in cpp_outline.read(text).classes[0].members]


class CheckClassesTest(unittest.TestCase):
    def found(self, sources, exceptions=""):
        return check_classes.violations(sources, exceptions)

    def assert_one(self, words, sources, exceptions=""):
        lines = self.found(sources, exceptions)
        self.assertEqual(1, len(lines), lines)
        for word in words:
            self.assertIn(word, lines[0])

    def test_a_class_in_one_file_passes(self):
        self.assertEqual([], self.found({PLAYER: HEADER, "server/a/player.cpp": PLAY + STOP + "}\n"}))

    def test_members_in_two_files_are_refused(self):
        sources = {PLAYER: HEADER, "server/a/player.cpp": PLAY + "}\n", "server/a/stop.cpp": "namespace hapticd {\n" + STOP + "}\n"}
        self.assert_one([PLAYER, "hapticd::Player", "2 files"], sources)
        self.assertEqual([], self.found(sources, "files 2 hapticd::Player two halves\n"))

    def test_members_under_an_alias_and_static_data_are_members(self):
        sources = {PLAYER: HEADER, "server/a/player.cpp": PLAY + STOP + "}\n",
                   "server/a/alias.cpp": "namespace hapticd {\nusing P = Player;\nvoid P::play(int) {}\n}\n"}
        self.assert_one(["2 files"], sources)
        sources["server/a/alias.cpp"] = "namespace hapticd {\nconst int Player::kMost[] = {1, 2};\n}\n"
        self.assert_one(["2 files"], sources)
        sources["server/a/alias.cpp"] = "Player::Inner hapticd::Player::inner(std::array<int, 2>) { return {}; }\n"
        self.assert_one(["2 files"], sources)

    def test_other_classes_of_the_same_name_are_others(self):
        local = "namespace hapticd {\nnamespace {\nclass Player { void stop(); };\n" + STOP + "}\n}\n"
        self.assertEqual([], self.found({PLAYER: HEADER, "server/a/player.cpp": PLAY + "}\n", "server/b/x.cpp": local}))
        other = HEADER.replace("hapticd", "other")
        self.assertEqual([], self.found({PLAYER: HEADER, "server/a/player.cpp": PLAY + "}\n", "server/b/player.h": other,
                                         "server/b/player.cpp": "namespace other {\n" + STOP + "}\n"}))

    def test_members_of_templates_and_free_functions_may_stand_anywhere(self):
        box = "template <class T> class Box { void put(T); };\ntemplate <class T> void Box<T>::put(T) {}\n"
        self.assertEqual([], self.found({"core/a/box.h": box, "core/a/x.cpp": "void detail::f() {}\n", "core/a/y.cpp": "void detail::g() {}\n"}))

    def test_more_than_twenty_public_members_are_refused(self):
        functions = [f"  void f{number}(int a, int b);\n" for number in range(20)]
        crowd = "class Crowd {\n public:\n  Crowd();\n  ~Crowd();\n  Crowd& operator=(const Crowd&) = delete;\n  enum class Kind { kA };\n%s};\n"
        self.assertEqual([], self.found({"core/a/crowd.h": crowd % "".join(functions)}))
        for one_more in ("  int data = 0;\n", "  void f0(double);\n", "  static int count();\n", "  bool operator==(const Crowd&) const;\n"):
            self.assert_one(["Crowd", "21 public", "at most 20"], {"core/a/crowd.h": crowd % "".join([*functions, one_more])})
        self.assertEqual([], self.found({"core/a/crowd.h": crowd % "".join([*functions, " private:\n  int data = 0;\n"])}))

    def test_a_plain_record_may_have_many_fields_and_a_struct_with_functions_elsewhere_may_not(self):
        record = "struct Options {\n  int " + ", ".join(f"a{number} = 0" for number in range(25)) + ";\n  bool any() const { return a0 > 0; }\n};\n"
        self.assertEqual([], self.found({"core/a/options.h": record}))
        self.assert_one(["Options", "26 public"], {"core/a/options.h": record, "core/a/x.cpp": "bool Options::any() const { return true; }\n"})

    def test_more_than_five_parameters_are_refused(self):
        self.assertEqual([], self.found({"core/a/x.cpp": "int f(int a, std::map<int, int> b, int c = g(1, 2), int d, int e[2]) { return 0; }\n"}))
        six = "int f(int a, int b, std::function<void(int, int)> c, int d, int e, int g) {\n  return h(1, 2, 3, 4, 5, 6, 7); }\n"
        self.assert_one(["core/a/x.cpp", "n::f", "6 parameters", "at most 5"], {"core/a/x.cpp": "namespace n {\n" + six + "}\n"})
        self.assert_one(["f", "6 parameters"], {"core/a/x.h": "template <class T, int N>\n" + six})
        self.assertEqual([], self.found({"core/a/x.cpp": "namespace n {\n" + six + "}\n"}, "parameters 6 n::f a kernel\n"))

    def test_exceptions_become_only_fewer(self):
        sources = {PLAYER: HEADER, "server/a/player.cpp": PLAY + STOP + "}\n"}
        self.assert_one(["needs no exception"], sources, "files 2 hapticd::Player two halves\n")
        self.assert_one(["needs no exception"], sources, "public 30 hapticd::Gone it was large\n")
        seven = {"core/a/x.cpp": "int f(int, int, int, int, int, int, int) { return 0; }\n"}
        self.assert_one(["is 7 now"], seven, "parameters 8 f a kernel\n")
        self.assert_one(["7 parameters; at most 6"], seven, "parameters 6 f a kernel\n")

    def test_exceptions_need_a_reason(self):
        for line in ("files 2 hapticd::Player", "lines 2 hapticd::Player long", "files two hapticd::Player halves"):
            self.assert_one(["is not RULE NUMBER NAME REASON"], {}, line + "\n")
        self.assertIn("twice", "".join(self.found({}, "files 2 a b\nfiles 2 a b\n")))


class CppOutlineTest(unittest.TestCase):
    def test_comments_texts_and_directives_are_passed_over(self):
        text = '#define A { \\\n  {\n// {\n/* { */ const char* a = "{ \\" {"; char b = \'{\'; auto c = R"x({ " )x"; int d = 1\'000;\nstruct S { int e; };\n'
        outline = cpp_outline.read(text)
        self.assertEqual([("S",)], [each.name for each in outline.classes])
        self.assertEqual(5, outline.classes[0].line)

    def test_members_are_told_from_what_is_none(self):
        text = """class A final : public B<int>, private C {
 public:
  using X = int; friend class D; enum E { kA, kB }; struct Inner { int z; }; class Ahead; static_assert(sizeof(int) == 4);
  template <class T, int N = (1 < 2)> [[nodiscard]] T get(const std::map<T, int>& m = {}) const { return m < 3 ? m : 4; }
  explicit operator bool() const; bool operator<(const A&) const; int operator()(int) const;
  alignas(64) std::atomic<int> a{1}; int b = f(1, 2), c[2] = {}; std::function<void(int)> d; static constexpr int kShift = 1 << 3;
 protected: int e; private: int g; };
"""
        outline = cpp_outline.read(text)
        own = next(each for each in outline.classes if each.name == ("A",))
        public = [member.name for member in own.members if member.access == "public"]
        self.assertEqual(["get", "operatorbool", "operator<", "operator()", "a", "b", "c", "d", "kShift"], public)
        self.assertEqual(["operatorbool", "operator<", "operator()", "get"],
                         sorted((member.name for member in own.members if member.is_function), key=lambda name: name == "get"))
        self.assertEqual(["e", "g"], [member.name for member in own.members if member.access != "public"])

    def test_functions_are_told_from_data_and_calls(self):
        text = """namespace a::b {
namespace {
const std::array<int, 2> kTable{1, 2};
const auto f = [](int x, int y) { return x < y; };
int plain(int, int) { return 0; }
}
A::A(int x) : y_{x}, z_(x, x), w_{} { }
A::~A() = default;
std::pair<int, B<3>> A::Inner::operator+(const A&, int) noexcept(false) { return {}; }
int declared(int);
TEST_CASE("a, b") { }
extern "C" { void c_function(void) { } }
}
"""
        found = {"::".join(each.name): each.parameters for each in cpp_outline.read(text).functions}
        self.assertEqual({"a::b::plain": 2, "a::b::A::A": 1, "a::b::A::~A": 0, "a::b::A::Inner::operator+": 2, "a::b::c_function": 0}, found)

    def test_names_of_a_file_alone_are_those_in_anonymous_namespaces(self):
        text = """namespace a {
namespace {
constexpr int kOne = 1, kTwo = 2; enum class E { kX }; struct S { int member; void f(); }; using L = long; int f(int x) { return x; }
}
int g() { return 0; }
namespace b { constexpr int kThree = 3; }
}
"""
        self.assertEqual({"kOne", "kTwo", "E", "S", "L", "f"}, cpp_outline.read(text).own)


class UnityGroupsTest(unittest.TestCase):
    def groups(self, *texts):
        sources = [unity_groups.Source(str(number), text) for number, text in enumerate(texts)]
        return [[int(source.path) for source in members] for members in unity_groups.group(sources)]

    def test_what_shares_no_name_is_compiled_together_up_to_a_number(self):
        self.assertEqual([list(range(8)), [8, 9]], self.groups(*(f"namespace {{ int f{number}() {{ return 0; }} }}" for number in range(10))))

    def test_a_name_of_one_file_alone_stands_in_no_other_of_the_group(self):
        own = "namespace { int place() { return 0; } }"
        for other in (own, "int call() { return place(); }", "namespace { const int place = 0; }", "namespace { struct place {}; }"):
            self.assertEqual([[0], [1]], self.groups(own, other), other)
        self.assertEqual([[0, 1]], self.groups(own, "// place\nint call() { return a.place(); }"))
        self.assertEqual([[0], [1]], self.groups("#define SIZE 3\n", "int a[SIZE];"))

    def test_a_name_of_one_file_alone_is_none_of_a_header_that_another_includes(self):
        with tempfile.TemporaryDirectory() as folder:
            inner, outer = os.path.join(folder, "inner.h"), os.path.join(folder, "outer.h")
            with open(inner, "w", encoding="utf-8") as file:
                file.write("using Bytes = int;\ninline constexpr std::int64_t kTick_ns = 1;\nclass Spring {\n};\nint move(int way);\n")
            with open(outer, "w", encoding="utf-8") as file:
                file.write(f'#include "{inner}"\n')
            for own, groups in (("using Bytes = char;", [[0], [1]]), ("const int kTick_ns = 3;", [[0], [1]]), ("int Spring = 0;", [[0], [1]]),
                                ("int way = 0;", [[0, 1]])):
                self.assertEqual(groups, self.groups(f"namespace {{ {own} }}", f'#include "{outer}"\n'), own)

    def test_an_alias_that_means_the_same_may_be_in_both(self):
        alias = "namespace { using Long = std::array<long, 3>; Long %s; }"
        self.assertEqual([[0, 1]], self.groups(alias % "one", alias % "two"))
        self.assertEqual([[0], [1]], self.groups(alias % "one", "namespace { using Long = std::array<long, 4>; Long two; }"))


class CountParametersTest(unittest.TestCase):
    def test_functions_are_counted_by_folder(self):
        many = "int f(int, int, int, int, int) { return 0; }\n"
        rows = count_parameters.rows({"core/a/x.cpp": many + "int g() { return 0; }\n", "core/a/x.h": "int f(int);\n", "core/b/y.cpp": many,
                                      "server/c/z.cpp": "int h() { return 0; }\n", "tests/a/x_test.cpp": many})
        self.assertEqual([("core", 3, 2), ("core/a", 2, 1), ("core/b", 1, 1), ("server", 1, 0), ("server/c", 1, 0), ("all", 4, 2)], rows)


if __name__ == "__main__":
    unittest.main()
