// See touched_string.h. RT: yes.
#include "core/contact/touched_string.h"

namespace hapticd {

StringBend moved(const StringBend& bend, const StringMotion& motion) noexcept {
  return {bend.capsule, std::clamp(bend.lambda + motion.dlambda, 0.0, 1.0), bend.u_W + motion.du_W};
}

}  // namespace hapticd
