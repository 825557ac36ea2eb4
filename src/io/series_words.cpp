#include "io/series_words.hpp"

#include <cctype>
#include <regex>

namespace sanatrix::io {
namespace {

/// Lower case, words apart by single blanks. Names are short; the rest of a long text is not looked
/// at.
std::string as_words(const std::string& description) {
  std::string words = " ";
  for (const char c : description.substr(0, 256)) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) != 0) {
      words += static_cast<char>(std::tolower(letter));
    } else if (words.back() != ' ') {
      words += ' ';
    }
  }
  return words;
}

}  // namespace

bool names_fat_suppression(const std::string& description) {
  static const std::regex denied(R"(\b(non?|not|without|w ?o) ?(fs|fat ?s(at|upp)\w*)\b)");
  // TIRM and STIR null fat by inversion, SPIR and SPAIR by selective inversion, WE excites water;
  // VIBRANT and THRIVE are fat-suppressed dynamic series.
  static const std::regex said(
      R"(\b(\w*fs|fat ?s(at|upp)\w*|\w*(spair|stir|tirm)\w*|spir|water ?excit\w*|we|vibrant|e?thrive)\b)");
  const std::string words = as_words(description);
  return !std::regex_search(words, denied) && std::regex_search(words, said);
}

bool names_computed_image(const std::string& description) {
  static const std::regex said(
      R"(\b(sub\d*|subtr\w*|mip|mpr|adc|e?dwi|\w*diff\w*|trace\w*|b ?\d{2,4}|t[12] ?map|wash ?(in|out)|dixon( \w+)* (w|f|water|fat|opp|out\w*))\b)");
  return std::regex_search(as_words(description), said);
}

bool names_localizer(const std::string& description) {
  static const std::regex said(R"(\b(locali[sz]er\w*|\w*scout\w*|survey)\b)");
  return std::regex_search(as_words(description), said);
}

}  // namespace sanatrix::io
