"""sanatrix verify: the table, the exit code and the page. The cases themselves are tests of their own."""
import json
import xml.etree.ElementTree as xml

from sanatrix_cli import CliTest, main


class Verify(CliTest):
    def test_the_page_has_the_numbers_of_the_run_and_repeats(self):
        pages = []
        for name in ["one", "two"]:
            done = self.run_ok("verify", "--only", "mms-species-explicit", "--json", "-q",
                               "--write", self.folder / name)
            result = json.loads(done.stdout)
            self.assertTrue(result["pass"])
            pages.append((self.folder / name / "README.md").read_text())
        check = result["cases"][0]["checks"][0]
        self.assertLess(abs(check["computed"] - 1.0), 0.1)  # explicit Euler: first order
        self.assertIn(f"{check['computed']:.5g}", pages[0])
        self.assertEqual(pages[0], pages[1])
        for chapter in ["Question of interest", "Context of use", "Code verification",
                        "Calculation verification", "Validation", "Applicability",
                        "What is not validated"]:
            self.assertIn(chapter, pages[0])
        plot = xml.parse(self.folder / "one/mms-species-explicit.svg").getroot()
        self.assertTrue(plot.tag.endswith("svg"))

    def test_an_unknown_case_is_refused_with_the_known_ones(self):
        self.refused(1, "verify", "--only", "nothing", says=["nothing", "mms-p1p1", "clinical-kader"])


if __name__ == "__main__":
    main()
