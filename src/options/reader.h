/* reader.h - declarations that only the files of the reader need. */
#ifndef MPM_READER_H
#define MPM_READER_H

#include "options/options.h"

#define MPM_FULL_LEN (2 * MPM_NAME_LEN) /* longest name of the vocabulary with a name of the scene in it */

struct _MPMOptions {
  const MPMVocabulary *table;
  char                 error[MPM_TEXT_LEN];
  PetscInt             dim, nm, nb, nl, np, nc, ns; /* of the declarations; all but dim are 0 before these */
  char (*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN], (*loads)[MPM_NAME_LEN], (*probes)[MPM_NAME_LEN],
      (*contacts)[MPM_NAME_LEN], (*stages)[MPM_NAME_LEN];
  PetscInt nasked, masked; /* full names that were asked for: number and capacity */
  char (*asked)[MPM_FULL_LEN];
};

/* Options of stages (stages.c): the option, in `given` itself, that it sets for a stage that is declared, or NULL; refuse one
   that is none, for which `nearest` is the closest name, or "". The second returns whether it is of a stage. */
const char *MPMOptionsOfStage(MPMOptions, const char given[]);
PetscBool   MPMOptionsRefuseOfStage(MPMOptions, const char given[], const char nearest[]);

/* Writes that the value of an option, -<name>, is too long; of a polygon what takes its place. */
void MPMOptionsTooLong(const char name[], size_t length, char text[], size_t len);

void MPMOptionsFullName(const char row[], const char name[], char full[MPM_FULL_LEN]);

/* Numbers in values (numbers.c). The first two read the value `text` of an option, one number or one an axis; faults
   are left in o. MPMOptionsDash returns a minus of Unicode in a text, or NULL. */
PetscReal   MPMOptionsNumber(MPMOptions o, const MPMOptionRow *row, const char full[], const char text[],
                             const char word[], PetscBool whole);
void        MPMOptionsList(MPMOptions o, const MPMOptionRow *row, const char full[], const char text[], PetscBool whole,
                           PetscReal value[3]);
const char *MPMOptionsDash(const char text[]);

/* Where options were given in files (places.c). */
void MPMOptionsNote(int file, const char name[], const char value[], const char path[], int line, char error[],
                    size_t len);
int  MPMOptionsNewFile(void);
/* Returns whether a name is that of an option, or of it in a stage. */
PetscBool MPMOptionsIsFor(const char name[], const char option[]);
void      MPMOptionsPlace(const char name[], const char value[], char place[], size_t len);
int       MPMOptionsPlaced(void);
PetscBool MPMOptionsIsPlaced(const char name[]);
void      MPMOptionsForgetPlaces(void);

/* Functions for the time before PETSc starts (files.c). MPMOptionsIsOption returns whether PETSc takes a word for an
   option (-1 and -inf are values). MPMOptionsCheckFile checks an options file, which `nesting` others include; error
   gets what is wrong. MPMOptionsCheckWords checks a word that should be an option, and the one after it, for what is
   written as other programs want it; fault [len] gets what is wrong, or "". MPMOptionsCheckYaml checks the text of a
   YAML file for contradictions (yaml.c). MPMOptionsForget forgets the files. MPMOptionsYaml is the YAML file that PETSc
   reads last, or NULL. */
PetscBool          MPMOptionsIsOption(const char word[]);
void               MPMOptionsCheckFile(const char name[], int nesting, char error[], size_t len);
void               MPMOptionsCheckWords(const char word[], const char next[], char fault[], size_t len);
void               MPMOptionsCheckYaml(const char path[], const char text[], char error[], size_t len);
PetscBool          MPMOptionsIsNumbers(const char word[]);
void               MPMOptionsForget(void);
extern const char *MPMOptionsYaml;

/* Prints the help (help.c) if `print`: whole if n is 0, else the lines that have all of these words. If there are none,
   it returns false, and fault [len] says so in one line. */
PetscBool MPMOptionsHelp(const MPMVocabulary *, int n, char **words, PetscBool print, char fault[], size_t len);

/* Returns the number of edits (insert, delete, replace, swap neighbours) between two words, whatever their case. */
int MPMOptionsDistance(const char a[], const char b[]);

/* What a formula may contain (expression.c): the title, and word k with its meaning; false if there are not so many. */
extern const char *const MPMFormulaTitle;
PetscBool                MPMFormulaWord(size_t k, const char **what, const char **meaning);

/* Values with paths of files (path.c). PathOf sets where `file`, named in the value of the option `full`, is; WholeOf
   makes a path whole, if there is the file. NoteWhole keeps what a value is with whole paths, and WholePath returns it,
   or NULL. */
void           MPMOptionsPathOf(const char full[], const char value[], const char file[], char path[MPM_TEXT_LEN]);
void           MPMOptionsWholeOf(char path[MPM_TEXT_LEN]);
PetscErrorCode MPMOptionsNoteWhole(const char name[], const char text[], const char with[]);
const char    *MPMOptionsWholePath(const char name[], const char text[]);

/* Words of other programs (words.c). AreAlike returns whether two words are the same but for case and for - _ * in
   them, and HasWord whether a list has the word of n characters. ForeignValue returns what to choose in place of a
   value of an option, Foreign what there is instead, if an option's name has such a word; or NULL. PrintWords prints
   the lines of a word, or of all (NULL), and returns how many there are. */
PetscBool   MPMOptionsAreAlike(const char a[], size_t na, const char b[], size_t nb);
PetscBool   MPMOptionsHasWord(const char words[], const char word[], size_t n);
const char *MPMOptionsForeignValue(const MPMVocabulary *, const char row[], const char value[]);
const char *MPMOptionsForeign(const MPMVocabulary *, const char given[]);
size_t      MPMOptionsPrintWords(const MPMVocabulary *, const char word[], PetscBool titled, PetscBool print);

#endif
