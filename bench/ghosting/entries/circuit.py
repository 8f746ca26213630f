"""The six named read-outs as equations, for entries that undo them: counts to currents, and the potential of every line.

Numbers come from sensor.toml's [readout] and [converter] alone. What docs/theory.md calls g_cu, g_cs, g_ru and g_rs is
here column_unselected, column_selected, row_unselected and row_selected.
"""

import numpy as np

OPEN = 1e-12  # siemens that an open line leaks, so that none is without a potential


def _per_line(value, lines):
    return np.broadcast_to(np.asarray(value, float), (lines,)).copy()


class Circuit:
    """A read-out whose every number the sensor file says."""

    def __init__(self, sensor):
        readout, self.converter = sensor["readout"], sensor["converter"]
        self.rows, self.columns = sensor["array"]["rows"], sensor["array"]["columns"]
        self.topology, self.v_test = readout["topology"], readout["v_test_volts"]
        if "diode" in readout:
            raise ValueError("a read-out with diodes is not linear")
        self.column_ohms = _per_line(readout["r_mux_column_ohms"], self.columns)
        driven_ohms = self.column_ohms + readout.get("r_source_ohms", 0.0)
        row_ohms = _per_line(readout["r_mux_row_ohms"], self.rows)
        if self.topology.startswith("tia"):
            gain = readout.get("open_loop_gain", 1e5)
            self.amperes_per_volt = (1 + gain) / gain / readout["r_feedback_ohms"]
            self.row_ohms = row_ohms + readout["r_feedback_ohms"] / (1 + gain)
        else:
            self.amperes_per_volt = 1 / readout["r_pull_down_ohms"]
            self.row_ohms = row_ohms + readout["r_pull_down_ohms"]
        self.read_share = 1 - row_ohms / self.row_ohms  # of the row's potential: what the follower copies
        self.series_ohms = driven_ohms[None, :] + self.row_ohms[:, None]
        self.column_selected, self.row_selected = 1 / driven_ohms, 1 / self.row_ohms
        is_open = self.topology in ("divider-floating", "divider-pulled-rows")
        self.column_unselected = np.full(self.columns, OPEN) if is_open else 1 / self.column_ohms
        held = self.topology in ("tia-zero-potential", "divider-pulled-rows")
        self.row_unselected = self.row_selected if held else np.full(self.rows, OPEN)
        self.follows = self.topology == "divider-voltage-feedback"

    def amperes_from_counts(self, counts):
        """Currents through the selected row's end; an offset that the file states is taken off."""
        volts = np.asarray(counts, float) * self.converter["full_scale_volts"] / (2 ** self.converter["bits"] - 1)
        return (volts - self.converter.get("offset_volts", 0.0)) * self.amperes_per_volt

    def siemens_alone(self, amperes):
        """What each taxel would be if no other were there: the reading freed of its own series path."""
        return amperes / np.maximum(self.v_test - amperes * self.series_ohms, 1e-3 * self.v_test)

    def potentials(self, siemens):
        """Volts of the selected row (R × C), and of all columns (R × C × C), for each selection of a row and a column."""
        selected = self._row_selected_inverses(siemens)  # R × n × n
        rows, columns = self.rows, self.columns
        source = self.column_selected * self.v_test
        change = self.column_selected - self.column_unselected
        own = np.arange(columns)
        all_columns = selected[:, rows:, rows:]  # R × C × C; [r, :, c] is the response to one ampere into column c
        row = selected[np.arange(rows), np.arange(rows), rows:]  # R × C: of row r to column c
        held = 1 + change * all_columns[:, own, own]
        row_volts = row * source / held
        column_volts = np.swapaxes(all_columns * (source / held[:, None, :]), 1, 2)
        if self.follows:
            self._follow(row, all_columns, change, held, row_volts, column_volts)
        return row_volts, column_volts

    def _follow(self, row, all_columns, change, held, row_volts, column_volts):
        """Adds what a follower of the sensed voltage drives into all columns but the selected one."""
        drive = self.column_unselected
        own = np.arange(self.columns)
        # Response to one volt of the follower at every column but c, without and then with the change of column c's end.
        at_row = (row @ drive)[:, None] - row * drive
        at_columns = (all_columns @ drive)[:, None, :] - np.swapaxes(all_columns * drive, 1, 2)
        at_own = at_columns[:, own, own] * change / held
        at_row = at_row - row * at_own
        at_columns = at_columns - np.swapaxes(all_columns, 1, 2) * at_own[:, :, None]
        followed = self.read_share[:, None] * row_volts / (1 - self.read_share[:, None] * at_row)
        row_volts += at_row * followed
        column_volts += at_columns * followed[:, :, None]

    def _row_selected_inverses(self, siemens):
        """The inverse nodal matrix with row r selected and no column, for each r."""
        rows = self.rows
        nodal = np.zeros((rows + self.columns,) * 2)
        nodal[:rows, rows:], nodal[rows:, :rows] = -siemens, -siemens.T
        ends = np.concatenate([siemens.sum(1) + self.row_unselected, siemens.sum(0) + self.column_unselected])
        nodal[np.diag_indices_from(nodal)] = ends
        change = self.row_selected - self.row_unselected
        lines = np.arange(rows)
        if self.topology == "divider-floating":
            # Nothing holds the lines until a row is selected, so that no common inverse is worth having.
            each = np.repeat(nodal[None], rows, 0)
            each[lines, lines, lines] += change
            return np.linalg.inv(each)
        inverse = np.linalg.inv(nodal)
        to_row = inverse[:rows]
        share = change / (1 + change * inverse[lines, lines])
        return inverse - share[:, None, None] * to_row[:, :, None] * to_row[:, None, :]
