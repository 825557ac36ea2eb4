#include "core/parallel.hpp"

#include <omp.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace sanatrix {

int threads() {
  return omp_get_max_threads();
}

void side_by_side(int count, const std::function<void(int)>& work) {
  static tbb::task_arena arena(threads());
  arena.execute([&] { tbb::parallel_for(0, count, work); });
}

}  // namespace sanatrix
