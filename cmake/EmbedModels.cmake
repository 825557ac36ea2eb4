# The parameter sets under models/ become string literals, so that the program needs no data files.
file(GLOB_RECURSE model_files CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/models/*.json)
set(entries "")
foreach(file ${model_files})
  file(RELATIVE_PATH name ${CMAKE_SOURCE_DIR}/models ${file})
  file(READ ${file} text)
  string(APPEND entries "    {\"${name}\", R\"json(${text})json\"},\n")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/embedded_models.cpp CONTENT
"// Generated from models/ by cmake/EmbedModels.cmake.
#include \"core/embedded_models.hpp\"
namespace sanatrix {
const std::map<std::string, std::string>& embedded_models() {
  static const std::map<std::string, std::string> models{
@entries@  };
  return models;
}
}  // namespace sanatrix
" @ONLY)
add_library(Models STATIC ${CMAKE_BINARY_DIR}/generated/embedded_models.cpp)
target_include_directories(Models PRIVATE ${CMAKE_SOURCE_DIR}/src)
