// The rule of a request, as the options of Item's fields state it. Not RT.
#pragma once

#include "hapticd/v1/request.pb.h"
#include "hapticd/v1/stream.pb.h"

namespace hapticd::wire {

/// The rule of what `item` asks for; null where it is no request that this version knows. Bye and
/// Chunk are none. Lives as long as the program. Some 10 ns, but for the first call.
[[nodiscard]] const v1::RequestRule* rule_of(const v1::Item& item);

/// The session must hold the lease; a request of that kind.
[[nodiscard]] bool needs_lease(const v1::Item& item);

/// The session must have the right to control, which the lease implies.
[[nodiscard]] bool needs_control(const v1::Item& item);

}  // namespace hapticd::wire
