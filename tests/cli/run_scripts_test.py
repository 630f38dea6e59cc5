"""The scripts of the README say what they do and choose what to install from one list."""
import os
import subprocess
import unittest

from harness import SOURCE, CommandLineTest


class Scripts(CommandLineTest):
    def bash(self, script):
        return subprocess.run(["bash", "-euo", "pipefail", "-c", f'source "{SOURCE}/.ci/setup.sh"; {script}'],
                              cwd=self.folder, text=True, capture_output=True)

    def test_packages_come_in_groups(self):
        packages = self.bash("list_packages build test").stdout.split()
        for name in ["cmake", "g++", "ninja-build", "libcgal-dev", "libgtest-dev"]:
            self.assertIn(name, packages)
        self.assertNotIn("gmsh", packages)
        self.assertFalse([name for name in packages if name.startswith("#")])

    def test_a_changed_added_or_removed_file_makes_a_stamp_old(self):
        for name in ["src/a.cpp", "src/b.cpp"]:
            (self.folder / name).parent.mkdir(exist_ok=True)
            self.write(name, "text")
        self.write("stamp", "")
        newer = "if is_newer stamp src; then echo old; else echo fresh; fi"

        def age(seconds):
            for path in [self.folder / "src", *(self.folder / "src").iterdir()]:
                os.utime(path, (path.stat().st_mtime - seconds,) * 2)

        age(10)
        self.assertEqual(self.bash(newer).stdout, "fresh\n")
        (self.folder / "src/b.cpp").unlink()
        self.assertEqual(self.bash(newer).stdout, "old\n")
        age(10)
        self.assertEqual(self.bash(newer).stdout, "fresh\n")
        self.write("src/c.cpp", "text")
        self.assertEqual(self.bash(newer).stdout, "old\n")
        self.assertEqual(self.bash(newer.replace("stamp", "missing")).stdout, "old\n")


if __name__ == "__main__":
    unittest.main()
