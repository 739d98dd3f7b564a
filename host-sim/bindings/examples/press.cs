// A press at 10 mm/s, from 5 mm above the site to 4 mm below it and back, as in press.c, from C#. Prints a line every tenth of
// a second, with "trace" every tick, and the hash of the tissue's state at the end.
using System;
using System.Globalization;
using Palpate;

static class Press {
    static int Main(string[] arguments) {
        CultureInfo.CurrentCulture = CultureInfo.InvariantCulture;
        bool trace = Array.IndexOf(arguments, "trace") >= 0;
        try {
            using (var session = Session.Open(arguments.Length > 0 && !trace ? arguments[0] : "block")) {
                Info info = session.Info;
                session.Arm();
                for (int tick = 0; tick < 2500; tick++) {
                    // the probe stays above the tissue until the force is ready, which takes 0.7 s
                    int steps = tick < 700 ? 0 : Math.Min(tick - 700, 2500 - tick);
                    double depth_m = 1e-5 * steps - 5e-3;
                    var tip_m = new Vector(info.site_m.x - info.axis.x * depth_m, info.site_m.y - info.axis.y * depth_m,
                        info.site_m.z - info.axis.z * depth_m);
                    Vector force_n;
                    Code code = session.Tick(tip_m, out force_n);
                    if (code != Code.Ok) throw new PalpateException(code, Session.FaultText(session.Report.fault));
                    if (trace || tick % 100 == 99)
                        Console.WriteLine("{0} ms {1:F3} mm {2:G9} {3:G9} {4:G9} N", tick + 1, depth_m * 1e3, force_n.x, force_n.y, force_n.z);
                }
                Console.WriteLine("state {0}", session.StateHash);
            }
            return 0;
        } catch (PalpateException failed) {
            Console.Error.WriteLine(failed.Message);
            return 1;
        }
    }
}
