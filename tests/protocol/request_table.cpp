// See request_table.h.
#include "tests/protocol/request_table.h"

#include <fstream>
#include <regex>
#include <stdexcept>

namespace hapticd::test {

std::map<std::string, std::string> documented_requests() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  if (!file.good()) throw std::runtime_error("proto/PROTOCOL.md cannot be read");
  std::map<std::string, std::string> needs;
  // "| `calibrate`, `recentre` | lease | ... |"
  const std::regex row("\\| (`\\w+`(?:, `\\w+`)*) \\| (control|lease|) ?\\|.*");
  const std::regex name("\\w+");
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("## ", 0) == 0) inside = line == "## 8 Requests";
    std::smatch match;
    if (!inside || !std::regex_match(line, match, row)) continue;
    const std::string names = match[1];
    for (std::sregex_iterator each(names.begin(), names.end(), name);
         each != std::sregex_iterator(); ++each) {
      needs[each->str()] = match[2];
    }
  }
  return needs;
}

}  // namespace hapticd::test
