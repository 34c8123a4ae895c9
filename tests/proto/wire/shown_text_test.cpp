// What of somebody else's text reaches a terminal.
#include "proto/wire/shown_text.h"

#include <doctest/doctest.h>

namespace hapticd::wire {
namespace {

TEST_CASE("every control is shown by its number, and everything else as it is") {
  CHECK(shown_text("a\x1b[31m") == "a\\u001b[31m");
  CHECK(shown_text(std::string("\0\x07\x7f\t", 4)) == "\\u0000\\u0007\\u007f\\u0009");
  CHECK(shown_text("\u009b2J\u0085") == "\\u009b2J\\u0085");
  CHECK(shown_text("\u202e\u2066\u200f\u2028\ufeff") == "\\u202e\\u2066\\u200f\\u2028\\ufeff");
  CHECK(shown_text("Gu\u00e9qin \u53e4\u7434 \U0001d11e \u00a0") ==
        "Gu\u00e9qin \u53e4\u7434 \U0001d11e \u00a0");
}

TEST_CASE("lines stay lines only where text may have several") {
  CHECK(shown_text("a\nb\r") == "a\\u000ab\\u000d");
  CHECK(shown_lines("a\nb\r") == "a\nb\\u000d");
}

TEST_CASE("of bytes that are no text a question mark is shown, and no control hides in them") {
  CHECK(shown_text("a\x9b"
                   "b\xc2") == "a?b?");
  CHECK(shown_text("\xe2\x80") == "??");
  CHECK(shown_text("\xc0\x9b") == "??");
}

TEST_CASE("a text is plain when it is shown as it is") {
  for (const char* text : {"", "holder", "H\u00f6lderlin 3", "\U0001d11e"}) {
    CHECK(is_plain(text));
    CHECK(shown_text(text) == text);
  }
  for (const char* text : {"\n", "a\x1b", "\u009b", "\x9b", "\u202e", "\x7f"}) {
    CHECK(!is_plain(text));
    CHECK(shown_text(text) != text);
  }
}

}  // namespace
}  // namespace hapticd::wire
