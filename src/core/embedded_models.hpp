// Parameter sets of models/, compiled in: "healing/vavourakis2016.json" -> text.
#pragma once

#include <map>
#include <string>

namespace sanatrix {

const std::map<std::string, std::string>& embedded_models();

}  // namespace sanatrix
