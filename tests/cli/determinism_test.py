"""The same command gives the same bytes, for any number of threads; another seed gives another mesh."""
import unittest

from harness import SOURCE, CommandLineTest, box_poly, square_poly


class Determinism(CommandLineTest):
    def bytes_of(self, threads, *options, domain="domain.poly"):
        self.succeed("mesh", domain, "-o", "a.node", "-o", "a.vtu", "--cells", "c.vtu", "--threads", threads, *options)
        names = [name for name in self.names() if name.split(".")[0] in ("a", "c")]
        return {name: (self.folder / name).read_bytes() for name in names}

    def test_threads_do_not_matter(self):
        for text in [square_poly(), box_poly()]:
            for options in [["--packing", "voronoi"], ["--interior", "random"], ["--packing", "maximal"],
                            ["--packing", "filtered"]]:
                with self.subTest(options=options, dimension=text.split()[1]):
                    self.write("domain.poly", text)
                    size = "0.05" if text.split()[1] == "2" else "0.2"
                    one = self.bytes_of(1, "--size", size, *options)
                    for threads in (2, 8):
                        self.assertTrue(self.bytes_of(threads, "--size", size, *options) == one, f"{threads} threads")

    def test_threads_do_not_matter_on_the_examples(self):
        for domain in sorted((SOURCE / "examples/domains").glob("*.poly")):
            with self.subTest(domain=domain.name):
                self.assertTrue(self.bytes_of(1, domain=domain) == self.bytes_of(8, domain=domain))

    def test_another_seed_gives_another_mesh(self):
        self.write("domain.poly", square_poly())
        options = ["--size", "0.1", "--interior", "random"]
        self.assertFalse(self.bytes_of(1, *options, "--seed", "1") == self.bytes_of(1, *options, "--seed", "2"))


if __name__ == "__main__":
    unittest.main()
