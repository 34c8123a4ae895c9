// What libprotobuf makes of our messages at their first use, made at the start: what it was in the
// middle of when memory was short it never mends, and later reads through null. Not RT.
#pragma once

namespace hapticd::wire {

/// Makes descriptors and reflection of all messages of the wire and of recordings, and the rules of
/// requests. Once, before anybody is served; some ms. Throws std::bad_alloc where there is too
/// little memory to start.
void prepare_messages();

}  // namespace hapticd::wire
