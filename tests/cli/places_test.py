"""Where results go and inputs lie: full and read-only disks, folders without permission, links to the input."""
import os
import subprocess
import unittest

from harness import PROGRAM, CommandLineTest, box_poly

NAMESPACE = ["unshare", "--map-root-user", "--mount"]
WITHOUT_PRIVILEGES = ["unshare", "--user"]  # Even root is denied then what permissions deny.


def can(command):
    try:
        return subprocess.run([*command, "true"], capture_output=True).returncode == 0
    except OSError:
        return False


@unittest.skipUnless(can(NAMESPACE), "needs namespaces of the user's own to mount a small disk")
class Disks(CommandLineTest):
    SCRIPT = 'mount -t tmpfs -o "$1" tmpfs disk && shift && { "$@"; code=$?; ls -A disk >left; exit $code; }'

    def setUp(self):
        super().setUp()
        self.write("box.poly", box_poly())
        (self.folder / "disk").mkdir()

    def run_on(self, disk, *arguments):
        """Runs the program with an empty file system in the folder "disk"; also returns what is in it at the end."""
        result = subprocess.run([*NAMESPACE, "sh", "-c", self.SCRIPT, "sh", disk, PROGRAM, *arguments], cwd=self.folder,
                                text=True, capture_output=True, timeout=120)
        left = (self.folder / "left").read_text().split()
        (self.folder / "left").unlink()
        return result, left

    def refused(self, disk, reason, *arguments):
        result, left = self.run_on(disk, *arguments)
        self.assertEqual((result.returncode, result.stdout, left), (2, "", []), result.stderr)
        self.assertRegex(result.stderr, rf"disk/\S+: cannot \w.*: {reason}  \[io\.cannot_write\]\n  Fix: \w+")
        self.assertNotIn(".voropack-", result.stderr, "the place is named as the user named it")
        self.assertEqual(self.names(), ["box.poly", "disk"])

    def test_a_disk_with_room(self):
        result, left = self.run_on("size=16m", "mesh", "box.poly", "--size", "0.3", "-o", "disk/a.vtu")
        self.assertEqual((result.returncode, left), (0, ["a.vtu"]), result.stderr)

    def test_a_disk_that_fills_up_keeps_nothing(self):
        mesh = ["mesh", "box.poly", "--size", "0.1"]
        for arguments in [["-o", "disk/a.vtu"], ["-o", "disk/a.node"], ["-o", "disk/new/a.vtu", "--report", "r.json"],
                          ["-o", "a.vtu", "--cells", "disk/cells.vtu", "--report", "disk/r.json"]]:
            with self.subTest(arguments=arguments):
                self.refused("size=32k", "No space left on device", *mesh, *arguments)

    def test_a_disk_without_room_for_names(self):
        self.refused("size=1m,nr_inodes=2", "No space left on device", "mesh", "box.poly", "--size", "0.5", "-o",
                     "disk/a.node")

    def test_a_read_only_disk_is_found_before_the_work(self):
        self.refused("ro", "Read-only file system", "mesh", "box.poly", "--size", "0.001", "-o", "disk/a.node")


@unittest.skipUnless(can(WITHOUT_PRIVILEGES), "needs namespaces of the user's own to give up privileges")
class Permissions(CommandLineTest):
    def denied(self, *arguments):
        result = subprocess.run([*WITHOUT_PRIVILEGES, PROGRAM, *arguments], cwd=self.folder, text=True,
                                capture_output=True, timeout=120)
        self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
        self.assertRegex(result.stderr, r"Permission denied  \[io\.cannot_\w+\]\n  Fix: \w+")
        return result.stderr

    def test_a_folder_that_may_not_be_written_to_is_found_before_the_work(self):
        self.write("box.poly", box_poly())
        (self.folder / "shut").mkdir(mode=0o555)
        for name in ["shut/a.vtu", "shut/new/a.vtu"]:
            self.assertIn(name, self.denied("mesh", "box.poly", "--size", "0.001", "-o", name))
        self.assertEqual(os.listdir(self.folder / "shut"), [])

    def test_a_file_that_may_not_be_read(self):
        self.write("box.poly", box_poly()).chmod(0)
        self.assertIn("box.poly", self.denied("mesh", "box.poly", "-o", "a.vtu"))


class Links(CommandLineTest):
    def test_an_output_that_leads_to_the_input_is_refused(self):
        self.write("box.poly", box_poly())
        self.succeed("mesh", "box.poly", "-o", "a.node", "--size", "0.5")
        before = (self.folder / "a.node").read_bytes()
        (self.folder / "soft.node").symlink_to("a.node")
        os.link(self.folder / "a.node", self.folder / "hard.node")
        names = self.names()
        for output in ["a.node", "./a.node", "soft.node", "hard.node", str(self.folder / "a.node")]:
            self.fail_with(2, "convert", "a.node", output, words=("input and the output", "cli.overwrites_input"))
        self.assertEqual((self.folder / "a.node").read_bytes(), before)
        self.assertEqual(self.names(), names)


if __name__ == "__main__":
    unittest.main()
