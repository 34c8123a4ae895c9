// Prints the schema, a line for each message, field and enum value, as data/schema_v1.txt keeps it.
#include <cstdio>

#include "tests/protocol/schema.h"

int main() {
  for (const std::string& line : hapticd::test::schema_lines()) std::printf("%s\n", line.c_str());
  return 0;
}
