// Reads scene.proto line by line: comments are gathered until the field they stand above. Not RT.
#include "tests/core/instrument/proto_range.h"

#include <fstream>
#include <regex>
#include <stdexcept>

namespace hapticd::test {

std::map<std::string, ProtoRange> proto_ranges() {
  static const char* const path = HAPTICD_SOURCE_DIR "/proto/hapticd/v1/scene.proto";
  static const std::regex message_line(R"(message (\w+) \{.*)");
  static const std::regex comment_line(R"(\s*// (.*))");
  static const std::regex field_line(R"(\s+[\w .]+ (\w+) = \d+;.*)");
  static const std::regex interval(R"(.*; ([\[(])([-\d.e]+), ([-\d.e]+)([\])]);.*\])");
  std::ifstream file(path);
  if (!file) throw std::runtime_error(std::string("no ") + path);

  std::map<std::string, ProtoRange> ranges;
  std::string line;
  std::string message;
  std::string comment;
  std::smatch match;
  while (std::getline(file, line)) {
    if (std::regex_match(line, match, comment_line)) {
      comment += ' ' + match[1].str();
      continue;
    }
    if (std::regex_match(line, match, message_line)) message = match[1];
    if (std::regex_match(line, match, field_line)) {
      const std::string name = message + '.' + match[1].str();
      if (std::regex_match(comment, match, interval)) {
        const std::string text =
            match[1].str() + match[2].str() + ", " + match[3].str() + match[4].str();
        ranges[name] = {std::stod(match[2]), std::stod(match[3]), match[1] == "[", match[4] == "]",
                        text};
      }
    }
    comment.clear();
  }
  return ranges;
}

}  // namespace hapticd::test
