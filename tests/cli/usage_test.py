"""The command line itself: help, versions, refusals, exit codes. Usage: usage_test.py PROGRAM"""
import json

from sanatrix_cli import CliTest, main, sanatrix


class Usage(CliTest):
    def test_help_shows_examples_first_and_lists_exit_codes(self):
        done = self.run_ok("--help")
        self.assertTrue(done.stdout.startswith("Examples: sanatrix "))
        self.assertIn("5 interrupted", done.stdout)

    def test_every_subcommand_has_help(self):
        for command in ["phantom", "new", "run", "status", "solve", "params", "score", "version"]:
            self.assertIn("Usage: sanatrix " + command, self.run_ok(command, "--help").stdout)

    def test_run_help_documents_parameters_and_stages(self):
        text = self.run_ok("run", "--help").stdout
        for word in ["surgery.margin_mm", "heal.mechanics_interval_days", "image, segment, mesh"]:
            self.assertIn(word, text)

    def test_parameters_and_version_are_machine_readable(self):
        keys = {p["key"] for p in json.loads(self.run_ok("params", "--json").stdout)}
        self.assertLessEqual({"mesh.target_vertices", "mesh.preset", "heal.preset", "heal.days",
                              "heal.scheme", "tissue.preset", "tissue.adipose_c1_pa",
                              "solver.element", "surgery.margin_mm"}, keys)
        self.assertIn("PETSc", json.loads(self.run_ok("version", "--json").stdout)["libraries"])
        self.assertIn("Not a medical device", self.run_ok("--version").stdout)

    def test_wrong_usage_ends_with_1(self):
        self.refused(1, says=["subcommand"])
        self.refused(1, "fly")
        self.refused(1, "run")
        self.refused(1, "run", "case", "--unknown")
        self.refused(1, "phantom", self.folder / "p", "--density", "wooden")
        self.refused(1, "phantom", self.folder / "p", "--volume-cm3", "10")

    def test_output_without_terminal_has_no_escape_codes(self):
        for words in [("--help",), ("status", self.folder), ("run", self.folder)]:
            done = sanatrix(*words)
            self.assertNotIn("\x1b", done.stdout + done.stderr)

    def test_a_folder_that_cannot_be_made_is_said_before_the_work(self):
        (self.folder / "file").write_text("")
        self.refused(4, "phantom", self.folder / "file", says=["cannot be made", "another folder"])

    def test_a_folder_that_is_no_case_is_bad_input(self):
        self.refused(2, "run", self.folder, says=["case.json", "sanatrix new"])
        self.refused(2, "status", self.folder / "absent")
        self.refused(2, "solve", self.folder / "absent.json", "--out", self.folder)


if __name__ == "__main__":
    main()
