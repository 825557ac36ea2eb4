#include "failure.hpp"

#include <filesystem>
#include <new>

#include "core/context.hpp"
#include "core/error.hpp"

namespace sanatrix::app {

Failure describe(const std::exception_ptr& problem) {
  try {
    std::rethrow_exception(problem);
  } catch (const Error& e) {
    return {exit_code(e.fault()), "error: " + e.one_line()};
  } catch (const Cancelled&) {
    return {exit_interrupted,
            "interrupted: what is finished is kept; run the same command again to go on"};
  } catch (const std::bad_alloc&) {
    return {exit_code(Fault::Resource), "error: not enough memory - use a coarser mesh"};
  } catch (const std::filesystem::filesystem_error& e) {
    return {exit_code(Fault::Resource),
            "error: " + e.code().message() + " - check free space and permissions"};
  } catch (const std::exception& e) {
    return {exit_code(Fault::Internal),
            std::string("error: ") + e.what() +
                " - this is a defect of Sanatrix: please report it with the case's run.log"};
  }
}

}  // namespace sanatrix::app
