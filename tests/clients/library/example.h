// The program in clients/library/README.md.
#pragma once

#include <cstdint>

int example(std::uint16_t port);
