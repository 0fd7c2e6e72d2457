#include "checks/read_case.hpp"

#include "checks/validation.hpp"
#include "scenario/reader.hpp"

namespace ductile::drivers {

Case parse_case(std::string_view text, const std::string& file,
                const std::vector<Override>& overrides) {
  Document document(text, file);
  for (const Override& override : overrides) document.apply(override);
  Case result = planned(parse_scenario(document));
  try {
    validate(result);
  } catch (const ScenarioError& error) {
    document.fail(error);
  }
  return result;
}

Case load_case(const std::filesystem::path& file, const std::vector<Override>& overrides) {
  return parse_case(read_text(file), file.string(), overrides);
}

}  // namespace ductile::drivers
