// The cores of this process: independent pieces of work side by side.
#pragma once

#include <functional>

namespace sanatrix {

/// Threads of this process: OMP_NUM_THREADS, or the machine's cores.
int threads();

/// Calls work(i) for every 0 <= i < count and returns when all are done. Whoever is free takes the
/// next piece: on a busy machine the caller does what nobody else came for, instead of waiting as
/// at a barrier. An exception of a piece arrives here.
void side_by_side(int count, const std::function<void(int)>& work);

}  // namespace sanatrix
